// What the tracker knows of the tool at one instant.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

#include "service/base/vec.h"

namespace omni::base {

enum class TrackingStatus : std::uint8_t {
  kAbsent = 0,   // no magnet in reach: pose fields are the last known ones, not valid before the first fix
  kLost = 1,     // was tracked, this scan did not fit: pose is the last good one
  kTracking = 2  // pose belongs to this scan
};

// What limits this state, as bits. docs/theory/tracking.md, Limits
enum ToolLimit : std::uint32_t {
  kToolTilted = 1,           // within 15 degrees of perpendicular to the radius: one direction of force is out of reach
  kToolCoarse = 2,           // far from the sensors: this scan alone knows the position to no better than 1 mm
  kToolFewReadings = 4,      // half of the readings are unusable: another pose could fit as well
  kToolSensorSaturated = 8,  // a sensor axis is at its limit and left out
  // A magnet is present, but no pose fits, not even out of reach: a second magnet, a stuck, swapped or broken sensor,
  // the calibration of another base.
  kToolContradicted = 16,
  kToolRepeated = 32,  // the scan's stamp did not advance: the state is that of the previous scan
  kToolFrozen = 64     // the stamp advances, but every sensor repeats the same reading: nothing is measured
};

// Which magnet the pen has.
enum class MagnetIdentity : std::uint8_t {
  kUnknown = 0,     // its moment is not known well enough yet
  kCalibrated = 1,  // the one of the calibration
  kKnown = 2,       // another one, learnt before
  kNew = 3          // another one, being learnt
};

// How uncertain a point of the tool is along one direction: variances of position and velocity, and their covariance.
struct PointNoise {
  double position_m2 = 0;
  double cross_m2_s = 0;
  double velocity_m2_s2 = 0;
};

// Frame B: origin at the core's centre, +z up, right handed, metres.
// The tool's axis u is the unit vector along the magnetic moment, from the magnet's centre to the tip.
// The device point (HIP) is position + tip_offset_m * axis.
struct ToolState {
  std::int64_t t_ns = 0;  // CLOCK_MONOTONIC of the Hall sample this state belongs to
  TrackingStatus status = TrackingStatus::kAbsent;
  bool ever_tracked = false;
  std::uint32_t limits = 0;          // ToolLimit bits
  Vec3 position_base_m;              // magnet centre
  Vec3 axis_base{0, 0, -1};          // u, |u| = 1
  Vec3 velocity_base_m_s;            // of the magnet centre
  Vec3 angular_velocity_base_rad_s;  // perpendicular to u: roll about u is not observable
  Vec3 device_point_base_m;
  Vec3 device_point_velocity_base_m_s;
  double gap_m = 0;  // nearest point of the magnet to the hull; < 0: inside
  // Covariance of (position 3, tangent of u 2), row-major 5x5, SI.
  std::array<double, 25> covariance{};
  PointNoise device_point_noise;        // along its worst direction
  PointNoise device_point_noise_along;  // along axis_base, where tilt does not count
  double chi2 = 0;                      // of this scan's fit, `dof` degrees of freedom
  int dof = 0;
  int iterations = 0;
  const char* hypothesis = nullptr;  // static: the tracker's name of what explained this scan; null: nothing did
  double field_rms_T = 0;            // |B| of the tool over this scan's usable readings, root mean square
  // What the tracker believes has changed since the base was calibrated. For reports; poses already account for it.
  std::uint32_t sensors_left_out = 0;  // bit i: sensor i is ignored ...
  std::uint32_t sensors_disagree = 0;  // ... and disagreed with the others when last checked
  Vec3 ambient_base_T;                 // uniform field since then, known while tracking
  double stray_rms_T = 0;              // root mean square contribution of nearby magnets to readings; 0: none detected
  double moment_scale = 1;  // moment of the pen's magnet over the calibrated one's, and its standard deviation
  double moment_sigma = 0;
  MagnetIdentity magnet = MagnetIdentity::kUnknown;
  double model_error_relative = 0;  // error of the tool's field in the calibration, estimated from readings
};
static_assert(std::is_trivially_copyable_v<ToolState>);

}  // namespace omni::base
