// A three-axis Hall sensor: its readings in a field, and their noise. The numbers are those of the LIS3MDL; other
// sensors have their own HallSensor.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>

namespace omni::magnetics {

// LIS3MDL operating modes, by their fastest rate.
enum class HallMode : std::uint8_t { kUltraHigh155Hz, kHigh300Hz, kMedium560Hz, kLow1000Hz };

struct HallSensor {
  std::array<double, 9> gain_sensor_base{1, 0, 0, 0, 1, 0, 0, 0, 1};  // row-major: R_SB with gains and misalignment
  Eigen::Vector3d background_sensor_T = Eigen::Vector3d::Zero();
  double range_T = 1.6e-3;
  double lsb_T = 1.0 / 17.11e6;  // data sheet: 1711 LSB per gauss
};

// rms per axis x, y, z. Ultra-high performance from the data sheet (3.2 / 3.2 / 4.1 mG); the others, which it does not
// give, by the white-noise law sigma ~ sqrt(rate): an assumption. docs/theory/magnetics.md (19)
std::array<double, 3> HallNoise_T(HallMode mode) noexcept;

// Standard deviation of an axis with noise `noise_T` after rounding to steps of `lsb_T`: uniform rounding adds
// lsb^2/12. Valid for noise_T > lsb_T / 3. docs/theory/magnetics.md (20)
double QuantisedNoise_T(double noise_T, double lsb_T) noexcept;

struct HallReading {
  Eigen::Vector3d field_sensor_T;  // clipped to the range and rounded to steps
  std::uint8_t saturated = 0;      // bit per axis: at its limit, only the sign is known
};

// Reading of the field B at the sensor, sampled `age_s` before now while B changes at `rate_base_T_s`.
// docs/theory/magnetics.md (18)
HallReading ReadHall(const HallSensor& sensor, const Eigen::Vector3d& field_base_T,
                     const Eigen::Vector3d& rate_base_T_s, double age_s) noexcept;

// d(reading)/dB before rounding; the rows of saturated axes are zero.
Eigen::Matrix3d HallJacobian(const HallSensor& sensor, std::uint8_t saturated) noexcept;

}  // namespace omni::magnetics
