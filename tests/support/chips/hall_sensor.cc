#include "tests/support/chips/hall_sensor.h"

#include <algorithm>
#include <cmath>

namespace omni::magnetics {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr std::array<double, 3> kUltraHigh_T{3.2e-7, 3.2e-7, 4.1e-7};  // LIS3MDL data sheet, table 3
constexpr double kUltraHigh_Hz = 155;

Matrix3d GainOf(const HallSensor& sensor) noexcept {
  return Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(sensor.gain_sensor_base.data());
}

}  // namespace

std::array<double, 3> HallNoise_T(HallMode mode) noexcept {
  constexpr double kRates_Hz[] = {kUltraHigh_Hz, 300, 560, 1000};
  const double factor = std::sqrt(kRates_Hz[static_cast<std::size_t>(mode)] / kUltraHigh_Hz);
  return {factor * kUltraHigh_T[0], factor * kUltraHigh_T[1], factor * kUltraHigh_T[2]};
}

double QuantisedNoise_T(double noise_T, double lsb_T) noexcept {
  return std::sqrt(noise_T * noise_T + lsb_T * lsb_T / 12);
}

// y = round(clip(G (B - age dB/dt) + background))
HallReading ReadHall(const HallSensor& sensor, const Vector3d& field_base_T, const Vector3d& rate_base_T_s,
                     double age_s) noexcept {
  const Vector3d y = GainOf(sensor) * (field_base_T - age_s * rate_base_T_s) + sensor.background_sensor_T;
  HallReading reading;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(std::abs(y[axis]) < sensor.range_T)) reading.saturated |= static_cast<std::uint8_t>(1U << axis);
    const double clipped = std::clamp(y[axis], -sensor.range_T, sensor.range_T);
    reading.field_sensor_T[axis] = sensor.lsb_T > 0 ? sensor.lsb_T * std::round(clipped / sensor.lsb_T) : clipped;
  }
  return reading;
}

Matrix3d HallJacobian(const HallSensor& sensor, std::uint8_t saturated) noexcept {
  Matrix3d J = GainOf(sensor);
  for (int axis = 0; axis < 3; ++axis) {
    if ((saturated >> axis) & 1U) J.row(axis).setZero();
  }
  return J;
}

}  // namespace omni::magnetics
