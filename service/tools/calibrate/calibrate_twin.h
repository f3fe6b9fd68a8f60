// The whole of a calibration on the twin in virtual time, a scripted hand doing what the person would (a simulation).
// The base is that of a sim::Rig with the same seed and imperfections.
#pragma once

#include <cstdint>
#include <functional>
#include <string>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/base/truth_parameters.h"
#include "service/calibration/fit/self_calibration.h"
#include "service/config/files/calibration_file.h"
#include "service/sim/twin/twin.h"
#include "service/tools/calibrate/calibrate_session.h"

namespace omni::tools {

// Sees the session after every scan.
using SessionObserver = std::function<void(const CalibrationSession&)>;

struct TwinCalibration {
  calibration::Outcome outcome;
  double middle_s = 0;  // of the recording, since the twin's start: the moment is that of this time
};

// `device`: its sensor_noise_T is the twin's. `observer` sees the session after every scan.
base::Result<TwinCalibration> CalibrateTwin(const base::DeviceGeometry& device, std::uint64_t seed,
                                            const base::TruthParameters& truth, const SessionOptions& options = {},
                                            const SessionObserver& observer = {});

// The nominal geometry with the tip of the pen that the twin's hand holds: the hand knows its own pen.
base::DeviceGeometry WithHeldTip(const base::DeviceGeometry& device, std::uint64_t seed,
                                 const base::TruthParameters& truth);

// The hand that calibrates the twin: a scripted person of the simulation, who takes the pen away, waves it and touches
// the hull as `omni calibrate` instructs.
struct CalibratingHand {
  double away_s = 6;  // pen out of reach: the coil sweep
  double wave_s = 22;
  int touches = 130;
  std::uint64_t seed = 1;
};

sim::HandScript MakeCalibratingHand(const base::DeviceGeometry& device, const CalibratingHand& options);

// Rests the tip in a dimple and swings the pen about it: `omni calibrate --tip`.
struct PivotingHand {
  base::Vec3 dimple_base_m{0, -0.07, 0.01};
  double rest_s = 1;      // upright, before it is leaned
  double tilt_rad = 0.6;  // greatest, from upright
  double swing_s = 12;
  std::uint64_t seed = 1;
};

sim::HandScript MakePivotingHand(const PivotingHand& options);

// Calibrations as files: those that `omni calibrate` writes, and cached ones of simulated bases.

// With today's date.
config::CalibrationFile CalibrationFileOf(const calibration::Outcome& outcome, const std::string& serial);

// Of the twin (a simulation) with this seed and these parameters, as config::FindTwin takes them: the one that Omni
// ships, else from the cache folder, or measured as `omni calibrate` does (half a minute) and cached there.
base::Result<base::Calibration> KeptTwinCalibration(const base::DeviceGeometry& device, std::uint64_t seed,
                                                    const std::string& twin);

}  // namespace omni::tools
