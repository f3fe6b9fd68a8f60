#include "service/tracker/model.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::tracker {
namespace {

using Eigen::Vector3d;

void PlaceSensors(const base::Calibration& calibration, Model& model) {
  model.sensors = static_cast<int>(calibration.sensors.size());
  for (std::size_t i = 0; i < kArraySensors; ++i) {
    const base::SensorCalibration& sensor = calibration.sensors[std::min(i, calibration.sensors.size() - 1)];
    const Vector3d s = base::ToEigen(sensor.position_base_m);
    const double r3 = s.squaredNorm() * s.norm();
    const Vector3d shape = r3 > 0 ? Vector3d(s / r3) : Vector3d::Zero();  // at the origin only where there is no core
    const base::Vec3& background = sensor.background_sensor_T;
    model.background_sensor_T[0][i] = background.x;
    model.background_sensor_T[1][i] = background.y;
    model.background_sensor_T[2][i] = background.z;
    for (std::size_t row = 0; row < 3; ++row) {
      model.sensor_position_base_m[row][i] = s[static_cast<int>(row)];
      model.sensor_over_r3_base[row][i] = shape[static_cast<int>(row)];
      for (std::size_t column = 0; column < 3; ++column) {
        model.gain_sensor_base[3 * row + column][i] = sensor.gain_sensor_base[3 * row + column];
        model.coil_map_T_A[(3 * i + row) * base::kCoilCount + column] = sensor.current_map_T_A[3 * row + column];
      }
    }
  }
}

void PlaceTool(const base::Calibration& calibration, Rung rung, ToolSource<double>& tool) {
  magnetics::DiscMagnet magnet = magnetics::MakeDiscMagnet(calibration.magnet, calibration.moment_Am2);
  if (rung != Rung::kFull) {
    magnet.zonal = {magnet.moment_Am2, 0, 0};
    magnet.point_count = 1;
    magnet.points = {};
    magnet.points[0].share = 1;
  }
  std::copy(magnet.zonal.begin(), magnet.zonal.end(), tool.zonal);
  tool.multipole = magnet.zonal[1] != 0 || magnet.zonal[2] != 0;
  tool.points = rung == Rung::kDipole || !(calibration.core_radius_m > 0) ? 0 : magnet.point_count;
  tool.core_radius_m = calibration.core_radius_m;
  tool.core_kappa = calibration.core_kappa;
  for (std::size_t i = 0; i < magnet.points.size(); ++i) {
    const magnetics::MagnetPoint& point = magnet.points[i];
    tool.ring_1_m[i] = point.ring_1_m;
    tool.ring_2_m[i] = point.ring_2_m;
    tool.axial_m[i] = point.axial_m;
    tool.moment_Am2[i] = point.share * magnet.moment_Am2;
  }
}

ToolSource<float> Narrow(const ToolSource<double>& tool) {
  ToolSource<float> narrow{};
  const auto copy = [](const auto& from, auto& to) {
    std::transform(std::begin(from), std::end(from), std::begin(to), [](double x) { return static_cast<float>(x); });
  };
  copy(tool.ring_1_m, narrow.ring_1_m);
  copy(tool.ring_2_m, narrow.ring_2_m);
  copy(tool.axial_m, narrow.axial_m);
  copy(tool.moment_Am2, narrow.moment_Am2);
  copy(tool.zonal, narrow.zonal);
  narrow.multipole = tool.multipole;
  narrow.points = tool.points;
  narrow.core_radius_m = static_cast<float>(tool.core_radius_m);
  narrow.core_kappa = static_cast<float>(tool.core_kappa);
  return narrow;
}

}  // namespace

Model MakeModel(const base::Calibration& calibration, Rung rung) {
  Model model;
  PlaceSensors(calibration, model);
  PlaceTool(calibration, rung, model.tool);
  model.tool_float = Narrow(model.tool);
  model.moment_Am2 = calibration.moment_Am2;
  model.noise_T = calibration.sensor_noise_T;
  model.magnet_radius_m = calibration.magnet.radius_m;
  model.magnet_half_height_m = calibration.magnet.shape == base::MagnetShape::kSphere
                                   ? calibration.magnet.radius_m
                                   : calibration.magnet.half_height_m;
  model.hull_radius_m = calibration.hull_radius_m;
  model.tip_offset_m = calibration.magnet.tip_offset_m;
  model.grid = MakeColdGrid(calibration);
  return model;
}

}  // namespace omni::tracker
