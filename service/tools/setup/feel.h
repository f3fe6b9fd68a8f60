// A shipped scene under the pen: omni setup is the application for as long as it takes.
#pragma once

#include <functional>
#include <string>

#include "service/base/result.h"
#include "service/tools/setup/setup_run.h"

namespace omni::tools {

struct Felt {
  double largest_force_N = 0;
  int presses = 0;  // of the button `select`
};

// Until `enough`, or in a rehearsal until the simulated hand has done what is to be done in this scene. Error: the
// scene cannot be used, or `patience_s` have passed, with what omnid says about it. Precondition: omnid runs.
base::Result<Felt> FeelScene(const SetupRun& run, const std::string& scene, double patience_s,
                             const std::function<bool(const Felt&)>& enough);

}  // namespace omni::tools
