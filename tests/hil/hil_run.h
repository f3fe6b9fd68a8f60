// One run of the whole chain: plant, core, USB, and a program started on it, beside the wall clock or in virtual time.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/sim/plant.h"

namespace omni::hil {

struct HilOptions {
  std::string board = "host";  // or "qemu"
  sim::PlantOptions plant;
  std::string record_path;           // CSV of truth and currents, every device tick; empty: none
  std::string summary_path;          // JSON; empty: standard output
  std::string scenario;              // empty: none
  double contact_timeout_s = 15;     // of device time, for the scenario
  double seconds = 0;                // of device time; 0: until the program ends
  bool paced = true;                 // false: virtual time, a tick per message of the host
  std::vector<std::string> program;  // with its arguments
};

// 0: the run did what it was asked for; what came of it stands in the summary. Messages go to stderr.
int RunHil(const base::DeviceGeometry& device, const HilOptions& options);

}  // namespace omni::hil
