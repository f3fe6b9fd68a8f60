// Manufacturing tolerances of a base, and the limits for accepting a recording.
#pragma once

namespace omni::calibration {

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

}  // namespace omni::calibration
