// What self-calibration works on: instants of the whole sensor array with the pen at unknown places, the coils' share
// per ampere and what the sensors read with nothing near.
#pragma once

#include <array>
#include <vector>

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

}  // namespace omni::calibration
