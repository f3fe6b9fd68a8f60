// An OpenXR application in a process of its own, over a real omnid and its twin.
#pragma once

#include <gtest/gtest.h>
#include <stdlib.h>

#include <cstdint>
#include <functional>
#include <string>

#include "tests/layer/support/app.h"
#include "tests/support/process/forked.h"
#include "tests/support/process/service_process.h"

namespace omni::test {

// omnid and its twin, where the layers of this process and its children look for them.
class StackService : public ServiceProcess {
 public:
  StackService(const std::string& scene, const std::string& hand) : ServiceProcess(scene, hand) {
    setenv("OMNI_SOCKET", socket_path().c_str(), 1);
    Start();
  }
};

// Runs `body` with an Application in a process of its own, which reports the time of its last step, 0 if it did not get
// that far; then `afterwards`.
template <class Application>
class ForkedApp : public Forked {
 public:
  ForkedApp(const std::function<std::int64_t(Application&)>& body, const std::function<void(Application&)>& afterwards)
      : Forked([&](const Report& report) {
          Application app;
          report(body(app));
          afterwards(app);
        }) {}
};

}  // namespace omni::test
