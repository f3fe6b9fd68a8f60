// What self-calibration is given and gives. It works on instants of the whole sensor array with the pen at unknown
// places, the coils' share per ampere and what the sensors read with nothing near.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::calibration {

// One instant of all sensors, from one scan or from a short window of scans (window.h).
struct Sample {
  double t_s = 0;                          // since any fixed instant
  std::vector<base::Vec3> field_sensor_T;  // as read: background and coils included; an axis not finite is not used
  double noise_scale = 1;                  // standard deviation, in units of Calibration::sensor_noise_T
  std::array<double, base::kCoilCount> coil_current_A{};  // measured
  bool touches_hull = false;                              // the magnet's housing rested on the hull
};

// Of one sensor: reading = background + map I, without a pen.
struct CoilResponse {
  base::Vec3 background_sensor_T;
  std::array<double, 9> map_sensor_T_A{};  // row-major: axis of S by coil
  double map_error_T_A = 0;                // standard deviation of one entry, from noise and hysteresis
};

struct Recording {
  std::vector<Sample> samples;
  std::vector<CoilResponse> responses;  // one per sensor; empty: maps and background stay nominal
};

// Standard deviations, the priors of the adjustment: manufacturing tolerances of the array and what the surroundings do
// during one recording. docs/theory/calibration.md (2.1)
struct Tolerances {
  double sensor_position_m = 1e-3;    // per axis: placement on the board, board in the base
  double sensor_gain = 0.015;         // per axis
  double sensor_rotation_rad = 0.02;  // 1.15 deg per axis
  double sensor_skew_rad = 3e-3;      // axes of one sensor not perpendicular
  double moment = 0.05;               // relative
  double moment_drift = 0.01;         // over the recording: a magnet that warms by 8 K
  double core_kappa = 0.003;          // ground to 0.01 mm, and iron of mu_r = 500 or more
  double hull_radius_m = 0.3e-3;
  double core_centre_m = 0.3e-3;       // per axis, from the centre of hull and windings
  double steel_strength = 0.5;         // of a plane under the base, 1: of much iron ...
  double steel_depth = 0.5;            // ... and its depth, natural logarithm of the ratio to kSteelDepth_m
  double ambient_T = 0.5e-6;           // common to all sensors, since the rest: offset and drift
  double remanence_A = 0.005;          // the core's memory, as a current of every sample in each coil
  double core_kept_A = 0.02;           // its remanence after every motion, as such a current; soft iron
  double coil_strength = 5e-3;         // winding and current sensor
  double coil_axis_rad = 1e-3;         // winding against the drawing: what fixes the frame
  double coil_shape = 1e-3;            // of a map's entry, relative to the field there: turns out of place
  double touch_m = 0.1e-3;             // hull and housing out of round
  double model_error_relative = 2e-4;  // of the magnet's field: what the model leaves out
};

// For accepting a recording.
struct Limits {
  int samples_min = 80;             // usable instants
  int touches_min = 20;             // fewer: the scale of the array stays open
  int on_hull_min = 12;             // of these, what turned out to be no rests in the air
  double coverage_min = 0.5;        // of the cells of the upper hemisphere
  double travel_min_m = 0.015;      // rms distance of the magnet from its mean place
  double saturated_max = 0.3;       // share of instants with saturated or missing axes
  double misfit_max = 0.3;          // share of instants that fit no pose
  double chi2_per_dof_max = 2.0;    // after adjustment
  double tolerance_sigmas_max = 5;  // a parameter beyond is a defect, not a tolerance
  double moment_max = 0.15;         // relative: beyond, it is another magnet
};

struct Options {
  Tolerances tolerances;
  Limits limits;
  int iterations_max = 60;
};

// What a calibration says about itself. SI.
struct SensorReport {
  double residual_T = 0;  // rms of its readings
  double chi2_per_reading = 0;
  double moved_m = 0;  // from the drawing
};

// A parameter that the recording did not determine: its uncertainty is mostly its tolerance.
struct Undetermined {
  std::string name;
  double sigma = 0;      // known to this, in `unit` ...
  double tolerance = 0;  // ... and before the recording to this
  std::string unit;
};

struct Report {
  int samples = 0;
  int touches = 0;
  int rests_in_air = 0;  // near the hull: taken for touches at first
  int rejected = 0;      // samples that fit no pose, or lost most of their weight
  double coverage = 0;   // of the upper hemisphere
  double chi2_per_dof = 0;
  int dof = 0;
  std::vector<SensorReport> sensors;
  double touch_rms_m = 0;
  double map_chi2_per_reading = 0;  // coils' shape against measured maps
  double moment_relative = 0;       // against the drawing
  double moment_sigma = 0;          // relative
  double moment_drift = 0;          // relative, over half the recording
  double frame_rotation_rad = 0;    // how well the frame's rotation about the core is known, per axis
  base::SteelPlane steel;           // under the base; strength 0: none was seen
  double expected_error_m = 0;      // rms position error that this calibration leaves, noise apart
  int weak_directions = 0;          // combinations of unknowns of which the tolerances say more than the recording
  std::vector<Undetermined> unfixed;
  int iterations = 0;
  double seconds = 0;
};

// Where over the base the pen has been: the upper hemisphere in cells of equal area.
inline constexpr int kCoverageBands = 4;    // by height, the lowest first
inline constexpr int kCoverageSectors = 6;  // by azimuth from +x
inline constexpr int kCoverageCells = kCoverageBands * kCoverageSectors;

struct Coverage {
  std::array<int, kCoverageCells> visits{};  // band * kCoverageSectors + sector

  void Add(const base::Vec3& position_base_m) noexcept;
  double share() const noexcept;  // of cells with a visit
};

}  // namespace omni::calibration
