// An application in a separate process, which a test stops and kills.
#pragma once

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdint>
#include <cstdio>
#include <exception>
#include <functional>

namespace omni::test {

class Forked {
 public:
  // Signals the test to continue, with a number from the application; to be called once.
  using Report = std::function<void(std::int64_t number)>;

  // Runs `body` until it returns or is killed. Waits until it has signalled or ended.
  explicit Forked(const std::function<void(const Report& report)>& body) {
    int ends[2];
    if (pipe(ends) != 0) return;
    pid_ = fork();
    if (pid_ == 0) {
      try {
        body([&](std::int64_t number) {
          if (write(ends[1], &number, sizeof(number)) != sizeof(number)) _exit(1);
        });
      } catch (const std::exception& problem) {  // must not become a second run of the tests
        std::fprintf(stderr, "application in a child: %s\n", problem.what());
        _exit(1);
      }
      _exit(0);
    }
    close(ends[1]);
    if (read(ends[0], &reported_, sizeof(reported_)) != sizeof(reported_)) reported_ = 0;
    close(ends[0]);
  }
  ~Forked() { Kill(); }
  Forked(const Forked&) = delete;
  Forked& operator=(const Forked&) = delete;

  std::int64_t reported() const { return reported_; }  // 0: nothing
  void Stop() const {
    if (pid_ > 0) kill(pid_, SIGSTOP);
  }
  void Kill() {
    if (pid_ <= 0) return;
    kill(pid_, SIGKILL);
    waitpid(pid_, nullptr, 0);
    pid_ = -1;
  }

 private:
  pid_t pid_ = -1;
  std::int64_t reported_ = 0;
};

}  // namespace omni::test
