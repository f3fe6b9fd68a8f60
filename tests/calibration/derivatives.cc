// Every derivative of the adjustment against central differences, and its model against the tracker's.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "service/base/eigen.h"
#include "service/calibration/fit/adjust.h"
#include "service/calibration/fit/system.h"
#include "service/calibration/fit/tool_field.h"
#include "service/magnetics/nominal.h"
#include "service/tracker/kernel/linearise.h"
#include "service/tracker/solve/gap.h"
#include "service/tracker/solve/solver.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig_recording.h"

namespace omni::calibration {
namespace test_calibration_derivatives {

using Eigen::Vector3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

sim::RigOptions Uncalibrated(std::uint64_t seed) {
  sim::RigOptions options{.seed = seed};
  options.sizes.sensor_position_m = 1e-3;
  options.sizes.sensor_gain = 0.015;
  options.sizes.sensor_rotation_rad = 0.02;
  return options;
}

// The frame is carried along without roll: the ring of five points is not quite round.
ToolFrame Turned(const ToolFrame& tool, const Eigen::Matrix<double, 5, 1>& step) {
  const Vector3d u = (tool.axis_base + step[3] * tool.e1 + step[4] * tool.e2).normalized();
  const Vector3d e1 = (tool.e1 - u.dot(tool.e1) * u).normalized();
  return {tool.position_base_m + step.head<3>(), u, e1, u.cross(e1)};
}

ToolFrame ToFrame(const sim::MagnetPose& pose) {
  return MakeToolFrame(base::ToEigen(pose.centre_base_m), base::ToEigen(pose.axis_base));
}

TEST(CalibrationDerivatives, FieldMatchesTrackerAndFiniteDifferences) {
  const base::Calibration nominal = magnetics::NominalCalibration(support::NominalDevice());
  const tracker::Model model = tracker::MakeModel(nominal);
  const auto unit = magnetics::MakeDiscMagnet(nominal.magnet, 1);
  const sim::Rig rig(support::NominalDevice(), {});
  sim::Random random(11);
  for (int n = 0; n < 100; ++n) {
    const ToolFrame tool = ToFrame(rig.DrawPose({.tilt_max_rad = 3}, random));
    tracker::ModelField expected;
    tracker::EvaluateField(model, tracker::MakePosePoint({tool.position_base_m, tool.axis_base}), expected);
    for (std::size_t i = 0; i < nominal.sensors.size(); ++i) {
      const Vector3d s = base::ToEigen(nominal.sensors[i].position_base_m);
      const FieldAtSensor sensor(s, nominal.core_radius_m);
      const ToolField field = sensor.Evaluate(unit, nominal.core_kappa, tool);
      const auto value = [&](const FieldAtSensor& at, const ToolFrame& frame) -> Vector3d {
        const ToolField f = at.Evaluate(unit, nominal.core_kappa, frame);
        return f.direct + nominal.core_kappa * f.image;
      };
      const Vector3d B = value(sensor, tool);
      const Vector3d tracked(&expected.field_sensor_T[3 * i]);
      EXPECT_LT((nominal.moment_Am2 * B - tracked).norm(), 1e-12 * tracked.norm());
      for (int c = 0; c < 5; ++c) {
        Eigen::Matrix<double, 5, 1> step = Eigen::Matrix<double, 5, 1>::Zero();
        step[c] = c < 3 ? 1e-6 : 1e-5;
        const Vector3d slope = (value(sensor, Turned(tool, step)) - value(sensor, Turned(tool, -step))) / (2 * step[c]);
        const double size = c < 3 ? field.by_pose.leftCols<3>().norm() : field.by_pose.rightCols<2>().norm();
        EXPECT_LT((slope - field.by_pose.col(c)).norm(), 1e-6 * size);
      }
      for (int c = 0; c < 3; ++c) {
        const Vector3d step = 1e-6 * Vector3d::Unit(c);
        const FieldAtSensor beyond(s + step, nominal.core_radius_m), before(s - step, nominal.core_radius_m);
        const Vector3d slope = (value(beyond, tool) - value(before, tool)) / 2e-6;
        EXPECT_LT((slope - field.by_sensor.col(c)).norm(), 1e-6 * field.by_sensor.norm());
      }
    }
  }
}

TEST(CalibrationDerivatives, GapMatchesTrackerAndFiniteDifferences) {
  const base::MagnetGeometry magnet = support::NominalDevice().magnet;
  const sim::Rig rig(support::NominalDevice(), {});
  sim::Random random(12);
  for (int n = 0; n < 300; ++n) {
    const ToolFrame tool = ToFrame(rig.DrawPose({.tilt_max_rad = 3}, random));
    const HullGap gap = GapToHull(magnet, 0.0375, tool);
    EXPECT_NEAR(gap.gap_m,
                tracker::CylinderGap(base::FromEigen(tool.position_base_m), base::FromEigen(tool.axis_base),
                                     magnet.radius_m, magnet.half_height_m, 0.0375),
                1e-15);
    for (int c = 0; c < 5; ++c) {
      Eigen::Matrix<double, 5, 1> step = Eigen::Matrix<double, 5, 1>::Zero();
      step[c] = 1e-7;
      const double slope =
          (GapToHull(magnet, 0.0375, Turned(tool, step)).gap_m - GapToHull(magnet, 0.0375, Turned(tool, -step)).gap_m) /
          2e-7;
      EXPECT_NEAR(slope, gap.by_pose[c], 1e-5) << n << " " << c;  // curvature at the rim: 1 / gap
    }
  }
}

// A small problem with everything in it: touches, maps, remanence, drift, a missing axis.
struct Small {
  base::DeviceGeometry device = support::NominalDevice();
  base::Calibration nominal = magnetics::NominalCalibration(device);
  Recording recording;
  Tolerances tolerances;
  std::vector<Instant> instants;
  explicit Small(int waves) {
    sim::Rig rig(device, Uncalibrated(5));
    recording = test::MakeRecording(rig, {.waves = waves, .touches = 4, .seed = 3});
    recording.samples[1].field_sensor_T[2].y = std::nan("");
    sim::Random random(3);
    for (const Sample& sample : recording.samples) {
      const ToolFrame tool = ToFrame(rig.DrawPose({.tilt_max_rad = sample.touches_hull ? 0.3 : 1.0}, random));
      instants.push_back({tool.position_base_m, tool.axis_base, 0.1 * Vector3d(1, -2, 3)});
    }
  }
};

TEST(CalibrationDerivatives, CostGradientMatchesFiniteDifferences) {
  const Small small(5);
  Problem problem(small.nominal, small.device.coils, small.recording, small.tolerances);
  Parameters parameters(problem.nominal(), small.tolerances);
  parameters.SetSteelFit(SteelFit::kStrengthAndDepth);
  problem.FollowCore(parameters, small.instants);
  EXPECT_GT(problem.observations()[1].kept.col(0).norm(), 0.1);
  EXPECT_GT(problem.observations().back().kept.col(1).norm(), 0.1);
  std::mt19937 rng(4);
  std::normal_distribution<double> normal(0, 0.5);
  for (double& x : parameters.x()) x = normal(rng);
  const System system = problem.Linearise(parameters, small.instants);
  const auto cost = [&](const Parameters& at, const std::vector<Instant>& instants) {
    return problem.Linearise(at, instants).cost;
  };
  for (int e = 0; e < parameters.size(); ++e) {
    Parameters more = parameters, less = parameters;
    const double h = 1e-4;
    more.x()[e] += h;
    less.x()[e] -= h;
    const double slope = (cost(more, small.instants) - cost(less, small.instants)) / (2 * h);
    EXPECT_NEAR(slope, 2 * system.g[e], 1e-5 * (std::abs(system.g[e]) + std::sqrt(system.H(e, e) * system.cost)))
        << parameters.Name(e);
  }
  for (std::size_t n = 0; n < small.instants.size(); ++n) {
    for (int c = 0; c < kOwn; ++c) {
      OwnVector step = OwnVector::Zero();
      step[c] = c < 3 ? 1e-7 : c < 5 ? 1e-6 : 1e-4;
      auto more = small.instants, less = small.instants;
      more[n] = MovedInstant(more[n], step);
      less[n] = MovedInstant(less[n], -step);
      const double slope = (cost(parameters, more) - cost(parameters, less)) / (2 * step[c]);
      const SampleBlock& block = system.samples[n];
      EXPECT_NEAR(slope, 2 * block.g[c], 1e-5 * (std::abs(block.g[c]) + std::sqrt(block.H(c, c) * system.cost)))
          << n << " " << c;
    }
  }
}

TEST(CalibrationDerivatives, EliminationMatchesTheDenseSolution) {
  const Small small(6);
  const Problem problem(small.nominal, small.device.coils, small.recording, small.tolerances);
  const Parameters parameters(problem.nominal(), small.tolerances);
  const System system = problem.Linearise(parameters, small.instants);
  const int array = parameters.size();
  const int size = array + kOwn * static_cast<int>(system.samples.size());
  Eigen::MatrixXd H = Eigen::MatrixXd::Zero(size, size);
  Eigen::VectorXd g = Eigen::VectorXd::Zero(size);
  H.topLeftCorner(array, array) = system.H;
  g.head(array) = system.g;
  for (int n = 0; n < static_cast<int>(system.samples.size()); ++n) {
    const SampleBlock& block = system.samples[static_cast<std::size_t>(n)];
    const int at = array + kOwn * n;
    H.block(at, at, kOwn, kOwn) = block.H;
    H.block(at, 0, kOwn, array) = block.C;
    H.block(0, at, array, kOwn) = block.C.transpose();
    g.segment(at, kOwn) = block.g;
  }
  const Eigen::VectorXd dense = H.ldlt().solve(g);
  const Reduced reduced = EliminateSamples(system, 0);
  const Eigen::VectorXd eliminated = reduced.H.llt().solve(reduced.g);
  EXPECT_LT((eliminated - dense.head(array)).norm(), 1e-6 * dense.head(array).norm());
}

}  // namespace test_calibration_derivatives
}  // namespace omni::calibration
