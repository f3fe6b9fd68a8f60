// One run of the whole chain: plant, core, USB, and programs started on it, in virtual time: CLOCK_MONOTONIC of the
// programs is the device's time, and goes on when all of them have done what there was to do (quiet.h). How fast the
// machine is does not matter.
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
  std::string hand_path;          // socket on which the hand is led; empty: its script is played
  std::string record_path;        // CSV of truth and currents, every device tick; empty: none
  std::string summary_path;       // JSON; empty: standard output
  std::string scenario;           // empty: none
  double contact_timeout_s = 15;  // of device time, for the scenario
  double seconds = 0;             // of device time; 0: until the first program ends
  bool paced = true;              // not faster than the wall clock: for people, and programs beside the clock
  std::string clock_path;         // of the virtual clock, for programs that somebody else starts; empty: none will
  // Each with its arguments. The first talks to the base, the others are its applications.
  std::vector<std::vector<std::string>> programs;
};

// Precondition: board and scenario are known ones, and there is a program. 0: the run did what it was asked for; what
// came of it stands in the summary. Messages go to stderr.
int RunHil(const base::DeviceGeometry& device, const HilOptions& options);

}  // namespace omni::hil
