// One run of the whole chain: plant, core, USB, and programs started on it, in virtual time: CLOCK_MONOTONIC of the
// programs is the device's time, and advances when all of them are idle (quiet.h), whatever the machine's speed.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/sim/coils/plant.h"

namespace omni::hil {

struct HilOptions {
  std::string board = "host";  // or "qemu"
  sim::PlantOptions plant;
  std::string hand_path;          // socket through which the hand is moved; empty: by its script
  std::string record_path;        // CSV of truth and currents, every device tick; empty: none
  std::string summary_path;       // JSON; empty: standard output
  std::string scenario;           // empty: none
  double contact_timeout_s = 15;  // of device time, for the scenario
  double seconds = 0;             // of device time; 0: until the first program ends
  bool paced = true;              // not faster than the wall clock: for users, and programs not under the clock
  std::string clock_path;         // of the virtual clock, for programs started elsewhere; empty: none
  // Each with its arguments. The first talks to the base, the others are its applications.
  std::vector<std::vector<std::string>> programs;
};

// Precondition: board and scenario are known ones, and there is a program. 0: the run completed; its results are in the
// summary. Messages go to stderr.
int RunHil(const base::DeviceGeometry& device, const HilOptions& options);

}  // namespace omni::hil
