// The paper's method: exact on data from its own model, and not on the twin.
#include <gtest/gtest.h>

#include <cmath>

#include "service/base/eigen.h"
#include "service/config/files/device_file.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/nominal.h"
#include "tests/bench/peers/paper_method.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/rig.h"

namespace omni::peers {
namespace test_peers_paper {

using base::Vec3;
using Eigen::Vector3d;

// Coils that are dipoles of 0.4 A m^2/A with a little crosstalk.
Eigen::Matrix3d CoilMoments() {
  Eigen::Matrix3d C = 0.4 * Eigen::Matrix3d::Identity();
  C(0, 1) = 0.006;
  C(2, 0) = -0.005;
  return C;
}

std::vector<Vec3> DipoleReadings(const base::Calibration& drawn, const Vector3d& p, const Vector3d& m,
                                 const Vector3d& current_A) {
  std::vector<Vec3> readings;
  for (const base::SensorCalibration& sensor : drawn.sensors) {
    const Vector3d s = base::ToEigen(sensor.position_base_m);
    readings.push_back(
        base::FromEigen(magnetics::DipoleField(m, s - p) + magnetics::DipoleField(CoilMoments() * current_A, s)));
  }
  return readings;
}

PaperModel DipoleWorld(const base::Calibration& drawn) {
  std::vector<Vec3> sweep(3 * drawn.sensors.size());
  for (int k = 0; k < 3; ++k) {
    const auto readings = DipoleReadings(drawn, {0, 0, 1}, Vector3d::Zero(), Vector3d::Unit(k));
    for (std::size_t i = 0; i < readings.size(); ++i) sweep[3 * i + static_cast<std::size_t>(k)] = readings[i];
  }
  return MakePaperModel(drawn, sweep);
}

TEST(PeersPaper, RecoversCoilMomentsAndPoseFromDipoleData) {
  const base::Calibration drawn = magnetics::NominalCalibration(config::DefaultDevice());
  const PaperModel model = DipoleWorld(drawn);
  for (int i = 0; i < 3; ++i) {
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(model.moment_per_ampere_Am2_A[static_cast<std::size_t>(3 * i + k)], CoilMoments()(i, k), 1e-12);
    }
  }
  PaperSolver solver(model);
  support::Rng rng(11);
  for (int n = 0; n < 40; ++n) {
    const Vector3d outwards = Vector3d(support::Uniform(rng, -1, 1), support::Uniform(rng, -1, 1), 1).normalized();
    const Vector3d p = support::Uniform(rng, 0.045, 0.1) * outwards;
    const Vector3d u = (-outwards + 0.5 * support::RandomUnit(rng)).normalized();
    const auto readings = DipoleReadings(drawn, p, drawn.moment_Am2 * u, {1, -2, 3});
    const PaperFit fit = solver.SolveCold({.field_sensor_T = readings, .current_A = {1, -2, 3}});
    EXPECT_LT((base::ToEigen(fit.pose.position_base_m) - p).norm(), 2e-5) << n;
    EXPECT_GT(base::ToEigen(AxisOf(fit.pose)).dot(u), 1 - 1e-6) << n;
    EXPECT_LT(fit.residual_rms_T, 1e-8);
  }
}

TEST(PeersPaper, GradientMatchesDifferences) {
  const base::Calibration drawn = magnetics::NominalCalibration(config::DefaultDevice());
  const PaperSolver solver(DipoleWorld(drawn));
  support::Rng rng(12);
  const auto readings = DipoleReadings(drawn, {0.01, 0.02, 0.06}, {0, 0, -5}, Vector3d::Zero());
  const PaperScan scan{.field_sensor_T = readings, .saturated_mask = 0b1001};
  for (int n = 0; n < 100; ++n) {
    const Vector3d p = 0.07 * (Vector3d::UnitZ() + 0.5 * support::RandomUnit(rng));
    const PaperPose pose{base::FromEigen(p), support::Uniform(rng, 0.3, 2.8), support::Uniform(rng, -3, 3)};
    std::array<double, 5> gradient{}, unused{};
    solver.Cost(scan, pose, gradient);
    double norm = 0, difference = 0;
    for (std::size_t k = 0; k < 5; ++k) {
      const auto cost = [&](double by) {
        PaperPose moved = pose;
        double* const values[] = {&moved.position_base_m.x, &moved.position_base_m.y, &moved.position_base_m.z,
                                  &moved.theta_rad, &moved.phi_rad};
        *values[k] += by;
        return solver.Cost(scan, moved, unused);
      };
      const double scale = k < 3 ? 0.05 : 1, h = 1e-3 * scale;
      const double numeric = (8 * (cost(h) - cost(-h)) - (cost(2 * h) - cost(-2 * h))) / (12 * h);
      norm += scale * scale * gradient[k] * gradient[k];
      difference += scale * scale * (gradient[k] - numeric) * (gradient[k] - numeric);
    }
    EXPECT_LT(std::sqrt(difference / norm), 1e-6);
  }
}

TEST(PeersPaper, HasMillimetreErrorsOnTheTwin) {
  // An exact rig without noise: what is left is the model's own error, 3.8 mm in the mean.
  const base::DeviceGeometry& device = config::DefaultDevice();
  sim::Rig rig(device, {.seed = 3, .sizes = sim::NoImperfections(), .noise = sim::NoiseMode::kNone});
  const base::Calibration drawn = magnetics::NominalCalibration(device);
  std::vector<Vec3> sweep(3 * drawn.sensors.size());
  for (std::size_t i = 0; i < drawn.sensors.size(); ++i) {
    const auto& map = drawn.sensors[i].current_map_T_A;
    for (std::size_t k = 0; k < 3; ++k) sweep[3 * i + k] = {map[k], map[3 + k], map[6 + k]};
  }
  PaperSolver solver(MakePaperModel(drawn, sweep));
  sim::Random random(4);
  double mean_mm = 0;
  const int n = 60;
  for (int i = 0; i < n; ++i) {
    const sim::MagnetPose pose = rig.DrawPose({}, random);
    const base::HallScan scan = rig.Scan(&pose, {}, random);
    const PaperFit fit =
        solver.SolveCold({.field_sensor_T = scan.field_sensor_T, .saturated_mask = scan.saturated_mask});
    mean_mm += 1e3 * (base::ToEigen(fit.pose.position_base_m) - base::ToEigen(pose.centre_base_m)).norm() / n;
  }
  EXPECT_GT(mean_mm, 2.5);
  EXPECT_LT(mean_mm, 5.5);
}

}  // namespace test_peers_paper
}  // namespace omni::peers
