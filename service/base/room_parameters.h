// Surroundings of a simulated base: steel, other magnets, a field that changes or turns, mains. All absent by default.
// Equations: docs/theory/truth.md. SI, frame B.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "service/base/vec.h"

namespace omni::base {

inline constexpr std::size_t kSteelMax = 16;        // pieces
inline constexpr std::size_t kOtherMagnetsMax = 4;  // beside the pen's
inline constexpr std::size_t kFieldStepsMax = 16;
inline constexpr std::size_t kSensorFaultsMax = 8;
inline constexpr std::size_t kPensMax = 8;

enum class SteelShape : std::uint8_t { kPlane, kBall, kBar };

// Acts as iron of infinite permeability, times its strength: a thin sheet is not a perfect mirror.
struct Steel {
  SteelShape shape = SteelShape::kPlane;
  Vec3 position_base_m;          // a point of the plane; the centre of a ball or bar
  Vec3 direction_base{0, 0, 1};  // unit; a plane's normal, towards the base; a bar's axis
  double radius_m = 0;           // of a ball; of a bar in its middle, which is a slender ellipsoid
  double half_length_m = 0;      // of a bar
  double strength = 1;           // [0, 1]
  double from_s = 0;             // it appears at this time of the run; 0: present from the start
};

// At rest at `from`, then straight to `to` at constant speed, at rest there.
struct OtherMagnet {
  Vec3 moment_Am2;
  Vec3 from_base_m, to_base_m;
  double leaves_s = 0, arrives_s = 0;  // leaves_s < arrives_s, or equal: it stands at `to` from then on
};

// Another pen is used from then on: of the same shape, with so much of the moment.
struct OtherPen {
  double moment_scale = 1;
  double from_s = 0;
};

// The ambient field changes by so much at an instant, or evenly over `over_s`.
struct FieldStep {
  Vec3 change_base_T;
  double at_s = 0, over_s = 0;
};

// A fault of one sensor.
enum class SensorFaultKind : std::uint8_t {
  kGain,     // reads `value` times what it should
  kStuck,    // repeats the same sample, marked fresh each time
  kHuge,     // reads `value` tesla on each axis
  kSwapped,  // swapped with sensor `other`
  kStopped   // no sample is fresh any more
};
struct SensorFault {
  SensorFaultKind kind = SensorFaultKind::kGain;
  int sensor = 0, other = 0;  // [0, kSensorCount)
  double value = 0;
  double from_s = 0;
};

struct RoomEffects {
  std::vector<Steel> steel;            // at most kSteelMax
  std::vector<OtherMagnet> magnets;    // at most kOtherMagnetsMax
  std::vector<OtherPen> pens;          // at most kPensMax; the last that has begun counts
  std::vector<FieldStep> steps;        // at most kFieldStepsMax
  std::vector<SensorFault> faults;     // at most kSensorFaultsMax
  double turn_rate_rad_s = 0;          // of the base about its z axis, in the earth's field, from turn_from_s ...
  double turn_from_s = 0, turn_s = 0;  // ... for turn_s
  double mains_T = 0;                  // amplitude at mains_Hz, in a random direction
  double mains_Hz = 50;
  double mains_third = 0, mains_fifth = 0;  // amplitudes of these harmonics, as shares of mains_T
  double scan_lost = 0, scan_late = 0;      // shares of the base's scans: that never arrive; a tick late
  double induction = 0;                     // of a moving pen in the coils; 1: as it is
};

}  // namespace omni::base
