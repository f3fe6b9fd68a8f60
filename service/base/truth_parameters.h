// How a simulated base and pen differ from their nominal geometry and change over a run: the numbers of
// manifests/device/twin.toml. Equations and sources: docs/theory/truth.md. Zero switches an effect off. SI.
#pragma once

#include <array>

#include "service/base/room_parameters.h"
#include "service/base/vec.h"

namespace omni::base {

// Standard deviations of independent normal errors. Defaults: what remains after a good calibration.
struct ImperfectionSizes {
  double sensor_position_m = 0.05e-3;  // per axis
  double sensor_gain = 1e-3;           // per axis
  double sensor_rotation_rad = 1.75e-3;
  double magnet_moment = 2e-3;
  double coil_strength = 1e-3;
  double coil_axis_rad = 1e-3;
  double current_gain = 1.5e-3;  // INA260: 0.15 %
  double current_offset_A = 2e-3;
  double coil_size = 0;            // relative, of a winding's radii and width at an equal number of turns
  double sensor_nonlinearity = 0;  // of full scale: greatest deviation from the best straight line, per axis
  // Since the background was measured; per axis.
  double sensor_offset_T = 0;
  double sensor_offset_T_K = 0, sensor_gain_1_K = 0;  // per kelvin of TruthEffects::sensor_warming_K
  double hull_radius_m = 0;
  double core_offset_m = 0;  // per axis, of the core's centre from the hull's and the coils'
  double core_size = 0;      // relative, of its radius
  double magnet_size = 0;    // relative, of radius and height each, at an equal moment
  double tip_offset_m = 0;   // of the pen's tip along its axis
};

// LIS3MDL: the quiet setting, ultra-high performance (at most 155 Hz), and the fast one, low power (1 kHz).
struct SensorParameters {
  std::array<double, 3> noise_uhp_T{3.2e-7, 3.2e-7, 4.1e-7};  // rms per axis
  std::array<double, 3> noise_lp_T{8e-7, 8e-7, 1e-6};
  double oscillator_spread = 0.005;  // sample rates differ by up to this much, relative
  double flicker_T = 0;              // rms per axis of the noise that lasts .01, .1, 1, 10 and 100 s, each
};

// Two nodes: each coil's copper, and the body (core, plastic, table) that all three share.
struct ThermalParameters {
  double copper_J_K = 44.4;
  double body_J_K = 94.2;
  double copper_to_body_W_K = 1.048;
  double body_to_air_W_K = 0.7903;
  double air_C = 24;
  double resistance_per_K = 0.00393;  // of copper, about 20 C
};

// Effects that the exact static model omits. All are off by default.
struct TruthEffects {
  double remanence_Am2 = 0;          // greatest remanent moment of the core (hysteresis)
  double core_conductivity_S_m = 0;  // eddy currents in the core
  double core_permeability = 1000;   // mu_r for the eddy currents; the static one is DeviceGeometry::core_kappa
  Vec3 earth_field_base_T;           // constant background
  bool background_known = true;      // calibration has removed the constant part: only the drift remains
  double ambient_drift_T = 0;        // by which the background has changed after run_s, in a random direction
  double magnet_warming_K = 0;       // by which the magnet is warmer after run_s
  double sensor_warming_K = 0;       // the same for the sensors
  double magnet_per_K = -1.2e-3;     // relative change of its moment
  double pwm_frequency_Hz = 0;       // current ripple at unsynchronised sampling
  double pwm_residual = 1;           // what a sensor's own averaging leaves of the ripple
  double run_s = 600;                // drift and warming are ramps over this time and stay there
  RoomEffects room;                  // surroundings of the base
};

struct TruthParameters {
  ImperfectionSizes imperfections;
  SensorParameters sensor;
  ThermalParameters thermal;
  TruthEffects effects;
};

}  // namespace omni::base
