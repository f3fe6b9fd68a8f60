// One simulated base and pen held still: static scans with or without noise, for calibration and for benchmarks that
// compare an estimate with the truth. A simulation: a reference for the tracker never shares its field code.
#pragma once

#include <array>
#include <cstdint>

#include "service/base/device_geometry.h"
#include "service/base/hall_scan.h"
#include "service/base/truth_parameters.h"
#include "service/sim/coils/effects.h"
#include "service/sim/fields/imperfections.h"
#include "service/sim/fields/random.h"
#include "service/sim/fields/truth_model.h"

namespace omni::sim {

// LIS3MDL: ultra-high performance (at most 155 Hz), low power (1 kHz).
enum class NoiseMode : std::uint8_t { kNone, kUltraHigh, kLowPower };
// rms per axis
std::array<double, 3> NoiseOf_T(NoiseMode mode, const base::SensorParameters& sensor = {}) noexcept;

struct RigOptions {
  std::uint64_t seed = 1;   // of the imperfections
  ImperfectionSizes sizes;  // all zero: nominal
  NoiseMode noise = NoiseMode::kUltraHigh;
  bool saturation = true;  // and quantisation; false: readings are the field itself
  base::TruthEffects effects;
  base::SensorParameters sensor;
};

// The base given by `truth` and the seed.
RigOptions OptionsOf(std::uint64_t seed, NoiseMode noise, const base::TruthParameters& truth);

// Range of random poses. The magnet never cuts the hull: such directions are drawn again, at the same radius.
struct PoseRange {
  double radius_min_m = 0.041, radius_max_m = 0.101;  // of the centre, uniform in the radius
  double elevation_min_rad = 0;                       // of the centre above the base's plane: upper hemisphere
  double tilt_max_rad = 1.0471975511965976;           // of the axis from the radial direction, either polarity inwards
};

class Rig {
 public:
  Rig(const base::DeviceGeometry& device, const RigOptions& options);

  // Result of a calibration without any error at time 0; the line of best fit of a bent sensor.
  base::Calibration ExactCalibration() const;

  MagnetPose DrawPose(const PoseRange& range, Random& random) const noexcept;

  // Without noise and without the core's memory. `pose` null: no pen.
  SensorFields Readings(const MagnetPose* pose, const CoilArray& current_A) noexcept;

  // As the device would report it at t_ns = now: noise, quantisation, saturation, measured currents. No motion: all
  // samples are of one instant, long after pose and currents have come to rest. The core remembers the previous scan.
  base::HallScan Scan(const MagnetPose* pose, const CoilArray& current_A, Random& random) noexcept;

  // Readings of the base's current sensors with the coils off: their offsets, which Scan() leaves out. A background
  // measured by a sweep of the base is valid only with them.
  CoilArray CurrentsAtRest_A() const noexcept;

  // Background and magnet as they are `t_s` after the start of the run; 0 at first.
  void SetTime(double t_s) noexcept { surroundings_ = environment_.At(t_s); }
  const Environment& environment() const noexcept { return environment_; }

  const base::DeviceGeometry& device() const noexcept { return device_; }
  TruthModel& truth() noexcept { return truth_; }
  const Imperfections& imperfections() const noexcept { return imperfections_; }
  const RigOptions& options() const noexcept { return options_; }

 private:
  base::DeviceGeometry device_;
  RigOptions options_;
  Imperfections imperfections_;
  Environment environment_;
  Surroundings surroundings_;
  CoreMemory memory_;
  bool remembers_ = false;  // memory_ has seen a scan
  TruthModel truth_;
  std::uint64_t sequence_ = 0;
};

}  // namespace omni::sim
