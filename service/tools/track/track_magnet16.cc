#include "service/tools/track/track.h"

#include <filesystem>
#include <numbers>

#include "service/base/eigen.h"
#include "service/tools/track/track_table.h"

namespace omni::tools {
namespace {

constexpr double kMicro = 1e-6;
constexpr double kMagnetisationMin_A_m = 1e4, kMagnetisationMax_A_m = 2e6;  // of permanent magnets

// Row-major gain R_SB from a rotation vector that takes the sensor's frame to the common one.
std::array<double, 9> GainOf(double gain, const Eigen::Vector3d& rotation) {
  const double angle = rotation.norm();
  Eigen::Matrix3d R_BS = Eigen::Matrix3d::Identity();
  if (angle > 0) R_BS = Eigen::AngleAxisd(angle, rotation / angle).toRotationMatrix();
  std::array<double, 9> map{};
  // Column-major R_BS read row by row: R_SB.
  Eigen::Map<Eigen::Matrix3d>(map.data()) = gain * R_BS;
  return map;
}

}  // namespace

base::Result<base::Calibration> ReadMagnet16Layout(const std::string& path, const Magnet16Options& options) {
  const auto table = TrackTable::Read(path);
  if (!table.ok()) return base::Error{table.error()};
  const auto there = table->Require({"sensor", "x_mm", "y_mm", "z_mm", "rotvec_x", "rotvec_y", "rotvec_z",
                                     "magnetization_A_per_m", "ambient_x_uT", "ambient_y_uT", "ambient_z_uT"});
  if (!there.ok()) return base::Error{there.error()};
  if (!(table->rows() >= base::kArraySensorsMin && table->rows() <= base::kArraySensorsMax)) {
    return base::Error{path + ": has " + std::to_string(table->rows()) + " sensors, must be 4 to 64"};
  }
  double mean_A_m = 0;
  for (std::size_t i = 0; i < table->rows(); ++i) {
    const auto sensor = table->Count(i, "sensor");
    if (!sensor.ok()) return base::Error{sensor.error()};
    if (*sensor != i) {
      return base::Error{table->Where(i) + "sensor " + std::to_string(*sensor) + " found where " + std::to_string(i) +
                         " is expected; list the sensors in order from 0"};
    }
    const double magnetisation_A_m = table->At(i, "magnetization_A_per_m");
    if (!(magnetisation_A_m >= kMagnetisationMin_A_m && magnetisation_A_m <= kMagnetisationMax_A_m)) {
      return base::Error{table->Where(i) + "magnetization_A_per_m = " + std::to_string(magnetisation_A_m) +
                         "; must be in [1e4, 2e6]: is it in A/m?"};
    }
    mean_A_m += magnetisation_A_m / static_cast<double>(table->rows());
  }
  base::Calibration array;
  array.device = std::filesystem::path(path).stem().string();
  array.magnet.radius_m = options.magnet_diameter_m / 2;
  array.magnet.half_height_m = options.magnet_height_m / 2;
  array.moment_Am2 =
      mean_A_m * std::numbers::pi * array.magnet.radius_m * array.magnet.radius_m * options.magnet_height_m;
  array.sensor_noise_T.fill(options.noise_T);
  for (std::size_t i = 0; i < table->rows(); ++i) {
    const auto at = [&](const char* column) { return table->At(i, column); };
    base::SensorCalibration sensor;
    sensor.position_base_m = {1e-3 * at("x_mm"), 1e-3 * at("y_mm"), 1e-3 * at("z_mm")};
    sensor.gain_sensor_base =
        GainOf(at("magnetization_A_per_m") / mean_A_m, {at("rotvec_x"), at("rotvec_y"), at("rotvec_z")});
    sensor.background_sensor_T = {kMicro * at("ambient_x_uT"), kMicro * at("ambient_y_uT"),
                                  kMicro * at("ambient_z_uT")};
    array.sensors.push_back(sensor);
  }
  return array;
}

}  // namespace omni::tools
