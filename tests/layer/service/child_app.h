// An OpenXR application in a process of its own, and what the coils did when something became of it.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstdio>
#include <exception>
#include <string>

#include "tests/layer/app.h"
#include "tests/support/service_process.h"

namespace omni::test {

inline constexpr double kWholeRecording_ms = 1e6;

// omnid and its twin, where the layers of this process and its children look for them.
class StackService : public ServiceProcess {
 public:
  StackService(const std::string& scene, const std::string& hand) : ServiceProcess(scene, hand) {
    setenv("OMNI_SOCKET", socket_path().c_str(), 1);
    Start();
  }
};

struct Child {
  pid_t pid = -1;
  std::int64_t t_ns = 0;  // what `body` returned; 0: it did not get so far
};

// Makes an `Application` in a process of its own: `body` gives the time of what it did, then `afterwards` goes on.
template <class Application, class Body, class Afterwards>
Child Fork(Body body, Afterwards afterwards) {
  int pipes[2];
  if (pipe(pipes) != 0) return {};
  Child child{.pid = fork()};
  if (child.pid == 0) {
    try {
      Application app;
      const std::int64_t t_ns = body(app);
      if (write(pipes[1], &t_ns, sizeof(t_ns)) != sizeof(t_ns)) _exit(1);
      afterwards(app);
    } catch (const std::exception& problem) {  // must not become a second run of the tests
      std::fprintf(stderr, "application in a child: %s\n", problem.what());
      _exit(1);
    }
    _exit(0);
  }
  close(pipes[1]);
  if (read(pipes[0], &child.t_ns, sizeof(child.t_ns)) != sizeof(child.t_ns)) child.t_ns = 0;
  close(pipes[0]);
  return child;
}

inline void End(const Child& child) {
  if (child.pid <= 0) return;
  kill(child.pid, SIGKILL);
  waitpid(child.pid, nullptr, 0);
}

// Ends the service. Milliseconds from t_ns until the coils were at zero for the rest of `horizon_ms`, by the twin's own
// recording; < 0: nothing was recorded then.
inline double CoilsAtZero_ms(ServiceProcess& service, const char* what, std::int64_t t_ns,
                             double horizon_ms = kWholeRecording_ms) {
  EXPECT_EQ(service.Stop(), 0);
  const auto truth = service.Truth();
  if (!truth.has_value()) return -1;
  EXPECT_GT(MillisecondsToZero(*truth, t_ns - 20'000'000, 20), 0) << what << ": it was pushing before";
  const double ms = MillisecondsToZero(*truth, t_ns, horizon_ms);
  std::printf("[ figure   ] OpenXR application: coils at zero %.1f ms after %s\n", ms, what);
  return ms;
}

}  // namespace omni::test
