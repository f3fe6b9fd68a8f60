// A simulated person who aligns a base: measured poses of controller and pen, with all errors of a headset. BasePoses
// are compared with the truth, which only the simulation knows.
#pragma once

#include <cstdint>

#include "service/tools/align/align.h"

namespace omni::test {

struct AlignNoise {
  double white_m = 0.3e-3;    // of a pose, per axis and sample
  double slow_m = 1.5e-3;     // wanders with slow_s: drift of the headset's tracking
  double white_rad = 0.9e-3;  // 0.05 degrees
  double slow_rad = 8.7e-3;   // 0.5 degrees
  double slow_s = 0.4;
  double tremor_m = 0.4e-3;   // of a hand that holds still
  double contact_m = 0.4e-3;  // where in a dimple a tip comes to rest, per touch
  double finger_m = 3e-3;     // bias of a fingertip, per touch
  double pen_m = 0.2e-3;      // the pen's tracker, per axis and sample
  double late_s = 0.008;      // the controller's poses are older than their stamps
  double tilt_rad = 5e-3;     // the desk, about each horizontal axis
  double wrong_touch = 0;     // probability that one touch is wrong, by 15 to 60 mm
  double jumps = 0;           // share of samples that are wrong by 20 to 100 mm (sweep)
};

struct AlignTrial {
  bool refused = false;
  std::string problem;
  alignment::Outcome outcome;
  alignment::Rigid truth;  // X_LB
  double error_m = 0;      // at the working point; of kCheck at the first mark
  double error_rad = 0;
  double seconds = 0;    // of the person's time
  int wrong_touch = -1;  // the mark that was touched wrongly
};

// One person, from the first pose to the end of the session, at 90 samples per second. Equal seeds give equal bits.
AlignTrial SimulateAlignment(const tools::AlignOptions& options, const AlignNoise& noise, std::uint64_t seed);

}  // namespace omni::test
