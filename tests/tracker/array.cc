// Arrays of any number of sensors, standing anywhere, with magnets of any shape: no core, no coils, no hull.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "service/base/eigen.h"
#include "service/magnetics/disc_magnet.h"
#include "service/tracker/solve/static_solve.h"
#include "tests/support/numeric.h"

namespace omni::tracker {
namespace test_tracker_array {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using support::Rng;
using support::Uniform;

// Sensors on a plate of 16 cm in all orientations, gains a few per cent off, far from the origin of B.
base::Calibration RandomArray(Rng& rng, int sensors, const base::MagnetGeometry& magnet) {
  base::Calibration array;
  array.device = "plate";
  const Vector3d corner(0.6, -0.2, 0.7);
  for (int i = 0; i < sensors; ++i) {
    base::SensorCalibration sensor;
    sensor.position_base_m = base::FromEigen(
        corner + Vector3d(Uniform(rng, -0.08, 0.08), Uniform(rng, -0.08, 0.08), Uniform(rng, -0.01, 0.01)));
    const Matrix3d R = Eigen::AngleAxisd(Uniform(rng, -3, 3), support::RandomUnit(rng)).toRotationMatrix();
    Eigen::Map<Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> gain(sensor.gain_sensor_base.data());
    gain = R * Vector3d(1.02, 0.97, Uniform(rng, 0.95, 1.05)).asDiagonal();
    sensor.background_sensor_T = {3e-5, -2e-5, 4e-5};
    array.sensors.push_back(sensor);
  }
  array.sensor_noise_T = {4e-7, 4e-7, 5e-7};
  array.magnet = magnet;
  array.moment_Am2 = 0.8;
  array.volume_min_base_m = base::FromEigen(corner + Vector3d(-0.08, -0.08, 0.025));
  array.volume_max_base_m = base::FromEigen(corner + Vector3d(0.08, 0.08, 0.10));
  return array;
}

Pose RandomPose(Rng& rng, const base::Calibration& array) {
  const Vector3d low = base::ToEigen(array.volume_min_base_m), high = base::ToEigen(array.volume_max_base_m);
  return {{Uniform(rng, low.x(), high.x()), Uniform(rng, low.y(), high.y()), Uniform(rng, low.z(), high.z())},
          support::RandomUnit(rng)};
}

std::vector<ArrayReading> Read(Rng& rng, const base::Calibration& array, const Model& model, const Pose& pose,
                               double noise_scale) {
  std::vector<double> field(array.sensors.size() * 3);
  std::vector<std::array<double, kParameters>> jacobian(field.size());
  EvaluateField(model, MakePosePoint(pose), field, jacobian);
  std::normal_distribution<double> normal;
  std::vector<ArrayReading> readings(array.sensors.size());
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const base::Vec3& background = array.sensors[i].background_sensor_T;
    readings[i].field_sensor_T = {
        field[3 * i] + background.x + noise_scale * array.sensor_noise_T[0] * normal(rng),
        field[3 * i + 1] + background.y + noise_scale * array.sensor_noise_T[1] * normal(rng),
        field[3 * i + 2] + background.z + noise_scale * array.sensor_noise_T[2] * normal(rng)};
  }
  return readings;
}

constexpr base::MagnetGeometry kLong{.radius_m = 0.004, .half_height_m = 0.008};
constexpr base::MagnetGeometry kFlat{.radius_m = 0.010, .half_height_m = 0.002};
constexpr base::MagnetGeometry kSphere{.shape = base::MagnetShape::kSphere, .radius_m = 0.006};

TEST(TrackerArray, ColdStartFindsAnyMagnetWithSixToSixtyFourSensors) {
  Rng rng(11);
  for (const int sensors : {6, 9, 16, 33, 64}) {
    for (const base::MagnetGeometry& magnet : {kLong, kFlat, kSphere}) {
      const base::Calibration array = RandomArray(rng, sensors, magnet);
      const auto solver = StaticSolver::Make(array, {});
      ASSERT_TRUE(solver.ok()) << solver.error();
      for (int i = 0; i < 20; ++i) {
        const Pose truth = RandomPose(rng, array);
        const StaticPose found = solver->Solve(Read(rng, array, solver->model(), truth, 1), {});
        ASSERT_EQ(found.status, StaticStatus::kFound) << sensors << " sensors, pose " << i;
        EXPECT_TRUE(found.cold);
        EXPECT_EQ(found.dof, 3 * sensors - 5);
        const double sigma_m = std::sqrt(found.covariance.topLeftCorner<3, 3>().trace());
        EXPECT_LT((found.pose.position_base_m - truth.position_base_m).norm(), 6 * sigma_m);
        EXPECT_GT(found.pose.axis_base.dot(truth.axis_base), 0.99);
      }
    }
  }
}

TEST(TrackerArray, WarmStartConvergesWithFourSensors) {
  Rng rng(12);
  for (int i = 0; i < 50; ++i) {
    const base::Calibration array = RandomArray(rng, 4, kFlat);
    const auto solver = StaticSolver::Make(array, {});
    ASSERT_TRUE(solver.ok()) << solver.error();
    const Pose truth = RandomPose(rng, array);
    const Pose start{truth.position_base_m + 0.001 * support::RandomUnit(rng), truth.axis_base};
    const StaticPose found = solver->Solve(Read(rng, array, solver->model(), truth, 0), {}, start);
    ASSERT_EQ(found.status, StaticStatus::kFound);
    EXPECT_FALSE(found.cold);
    EXPECT_LT((found.pose.position_base_m - truth.position_base_m).norm(), 1e-7);
  }
}

TEST(TrackerArray, JacobianMatchesFiniteDifferencesForEveryShape) {
  Rng rng(13);
  for (const base::MagnetGeometry& magnet : {kLong, kFlat, kSphere}) {
    const base::Calibration array = RandomArray(rng, 13, magnet);
    const Model model = MakeModel(array);
    const std::size_t readings = 3 * array.sensors.size();
    std::vector<double> field(readings), near_plus(readings), near_minus(readings), far_plus(readings),
        far_minus(readings);
    std::vector<std::array<double, kParameters>> jacobian(readings), unused(readings);
    for (int i = 0; i < 100; ++i) {
      const PosePoint point = MakePosePoint(RandomPose(rng, array));
      EvaluateField(model, point, field, jacobian);
      for (std::size_t k = 0; k < 3; ++k) {
        const auto at = [&](double step, std::vector<double>& result) {
          PosePoint moved = point;
          moved.position_base_m[k] += step;
          EvaluateField(model, moved, result, unused);
        };
        const double h = 2e-5;
        at(h, near_plus), at(-h, near_minus), at(2 * h, far_plus), at(-2 * h, far_minus);
        double error = 0, size = 0;
        for (std::size_t r = 0; r < readings; ++r) {
          const double numeric = (8 * (near_plus[r] - near_minus[r]) - (far_plus[r] - far_minus[r])) / (12 * h);
          error += std::pow(jacobian[r][k] - numeric, 2);
          size += numeric * numeric;
        }
        ASSERT_LT(std::sqrt(error / size), 1e-6);
      }
    }
  }
}

TEST(TrackerArray, InvalidReadingsAreExcludedOrRejected) {
  Rng rng(14);
  const base::Calibration array = RandomArray(rng, 12, kLong);
  const auto solver = StaticSolver::Make(array, {});
  ASSERT_TRUE(solver.ok());
  const Pose truth = RandomPose(rng, array);
  std::vector<ArrayReading> readings = Read(rng, array, solver->model(), truth, 1);
  readings[3].field_sensor_T.y = std::numeric_limits<double>::quiet_NaN();
  readings[5].field_sensor_T = {1, 1, 1};
  readings[5].saturated_axes = 7;
  StaticPose found = solver->Solve(readings, {});
  EXPECT_EQ(found.status, StaticStatus::kFound);
  EXPECT_EQ(found.dof, 36 - 4 - 5);
  EXPECT_TRUE(std::isnan(found.residual_T[10]));
  EXPECT_LT(std::abs(found.residual_T[9]), 3e-6);

  readings[7].field_sensor_T.x += 1e-4;  // 250 standard deviations
  found = solver->Solve(readings, {});
  EXPECT_EQ(found.status, StaticStatus::kPoorFit);

  for (auto& reading : readings) reading.saturated_axes = 7;
  EXPECT_EQ(solver->Solve(readings, {}).status, StaticStatus::kTooFew);
  readings.pop_back();
  EXPECT_EQ(solver->Solve(readings, {}).status, StaticStatus::kTooFew);
}

TEST(TrackerArray, RejectsBadCalibrationsNamingTheField) {
  Rng rng(15);
  const base::Calibration good = RandomArray(rng, 8, kFlat);
  const auto error_of = [&good](auto change) {
    base::Calibration bad = good;
    change(bad);
    const auto solver = StaticSolver::Make(bad, {});
    return solver.ok() ? std::string() : solver.error();
  };
  EXPECT_NE(error_of([](auto& c) { c.sensors.resize(3); }).find("sensors: 3"), std::string::npos);
  EXPECT_NE(error_of([](auto& c) { c.sensors.resize(65); }).find("4 to 64"), std::string::npos);
  EXPECT_NE(error_of([](auto& c) { c.sensors[2].gain_sensor_base[4] = std::nan(""); }).find("sensor 2"),
            std::string::npos);
  EXPECT_NE(error_of([](auto& c) { c.sensor_noise_T[1] = 0; }).find("noise"), std::string::npos);
  EXPECT_NE(error_of([](auto& c) { c.moment_Am2 = -1; }).find("moment"), std::string::npos);
  EXPECT_NE(error_of([](auto& c) { c.magnet.radius_m = std::nan(""); }).find("radius"), std::string::npos);
  EXPECT_NE(error_of([](auto& c) { c.core_radius_m = -1; }).find("core"), std::string::npos);
}

}  // namespace test_tracker_array
}  // namespace omni::tracker
