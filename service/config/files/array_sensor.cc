#include "service/config/files/array_sensor.h"

#include <cmath>
#include <numbers>

namespace omni::config {
namespace {

using Matrix = std::array<double, 9>;  // row-major

constexpr Range kPosition_m{-10, 10};
constexpr Range kDirection{-1.01, 1.01};
constexpr Range kAngle_rad{-2 * std::numbers::pi, 2 * std::numbers::pi};
constexpr Range kGain{-100, 100};
constexpr Range kBackground_T{-0.1, 0.1};
constexpr Range kMap_T_A{-1, 1};
constexpr double kUnitTolerance = 1e-2;
constexpr Range kRowLength{1e-3, 200};  // of an axis of the whole map: 0 would be a dead axis

// R_SB, the transpose of the rotation that a unit quaternion (w, x, y, z) makes.
Matrix TransposedRotation(const std::array<double, 4>& q) {
  const auto [w, x, y, z] = q;
  return {1 - 2 * (y * y + z * z), 2 * (x * y + w * z),     2 * (x * z - w * y),
          2 * (x * y - w * z),     1 - 2 * (x * x + z * z), 2 * (y * z + w * x),
          2 * (x * z + w * y),     2 * (y * z - w * x),     1 - 2 * (x * x + y * y)};
}

std::array<double, 4> Quaternion(FileProblem& problem, TableReader& reader) {
  std::array<double, 4> q{};
  reader.Numbers("orientation_base_sensor", kDirection, q);
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  if (!(std::abs(length - 1) <= kUnitTolerance)) {
    problem.Report(reader.table().get("orientation_base_sensor"),
                   reader.NameOf("orientation_base_sensor") + " has length " + std::to_string(length) +
                       "; must be a unit quaternion w, x, y, z (length 1)");
    return {1, 0, 0, 0};
  }
  for (double& value : q) value /= length;
  return q;
}

std::array<double, 4> FromRotationVector(TableReader& reader) {
  const base::Vec3 v = reader.Vector("rotation_base_sensor_rad", kAngle_rad);
  const double angle = Norm(v);
  const double s = angle > 0 ? std::sin(angle / 2) / angle : 0.5;
  return {std::cos(angle / 2), s * v.x, s * v.y, s * v.z};
}

Matrix Product(const Matrix& a, const Matrix& b) {
  Matrix c{};
  for (std::size_t row = 0; row < 3; ++row) {
    for (std::size_t k = 0; k < 3; ++k) {
      for (std::size_t column = 0; column < 3; ++column) c[3 * row + column] += a[3 * row + k] * b[3 * k + column];
    }
  }
  return c;
}

Matrix Gain(TableReader& reader) {
  const toml::node* node = reader.table().get("gain");
  if (node == nullptr) return {1, 0, 0, 0, 1, 0, 0, 0, 1};
  const toml::array* array = node->as_array();
  if (array == nullptr) {
    const double gain = reader.Number("gain", kGain);
    return {gain, 0, 0, 0, gain, 0, 0, 0, gain};
  }
  if (array->size() == 9) {
    Matrix gain{};
    reader.Numbers("gain", kGain, gain);
    return gain;
  }
  const base::Vec3 gain = reader.Vector("gain", kGain);
  return {gain.x, 0, 0, 0, gain.y, 0, 0, 0, gain.z};
}

Matrix Orientation(FileProblem& problem, TableReader& reader) {
  int given = 0;
  for (const char* key : {"orientation_base_sensor", "rotation_base_sensor_rad", "gain_sensor_base"}) {
    given += reader.table().contains(key) ? 1 : 0;
  }
  if (given > 1) {
    problem.Report(&reader.table(), reader.NameOf("orientation_base_sensor") +
                                        ", rotation_base_sensor_rad and gain_sensor_base exclude each other; keep one");
  }
  if (reader.table().contains("gain_sensor_base")) {
    Matrix whole{};
    reader.Numbers("gain_sensor_base", kGain, whole);
    return whole;
  }
  if (reader.table().contains("orientation_base_sensor")) return TransposedRotation(Quaternion(problem, reader));
  if (reader.table().contains("rotation_base_sensor_rad")) return TransposedRotation(FromRotationVector(reader));
  return {1, 0, 0, 0, 1, 0, 0, 0, 1};
}

}  // namespace

base::SensorCalibration ReadArraySensor(FileProblem& problem, TableReader& reader) {
  base::SensorCalibration sensor;
  sensor.position_base_m = reader.Vector("position_base_m", kPosition_m);
  const Matrix orientation = Orientation(problem, reader);
  sensor.gain_sensor_base = Product(Gain(reader), orientation);
  for (std::size_t row = 0; problem.ok() && row < 3; ++row) {
    const double* g = &sensor.gain_sensor_base[3 * row];
    const double length = std::hypot(g[0], g[1], g[2]);
    if (!(length >= kRowLength.low && length <= kRowLength.high)) {
      problem.Report(&reader.table(), reader.NameOf("gain") + ": axis " + std::to_string(row) + " has the gain " +
                                          std::to_string(length) + "; must be in [0.001, 200]");
    }
  }
  sensor.background_sensor_T = reader.Vector("background_sensor_T", kBackground_T, base::Vec3{});
  if (reader.table().contains("current_map_T_A")) reader.Numbers("current_map_T_A", kMap_T_A, sensor.current_map_T_A);
  return sensor;
}

}  // namespace omni::config
