// A steel plane under the base: how the tracker models it, and how calibration finds it.
#include <gtest/gtest.h>

#include <cmath>

#include "service/base/eigen.h"
#include "service/calibration/fit/self_calibration.h"
#include "service/calibration/fit/tool_field.h"
#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/nominal.h"
#include "service/tracker/kernel/steel.h"
#include "service/tracker/tracker.h"
#include "tests/support/rig/calibration_error.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig.h"
#include "tests/support/rig/rig_recording.h"

namespace omni {
namespace {

base::Steel PlaneAt(double z_m, double strength) {
  return {.shape = base::SteelShape::kPlane, .position_base_m = {0, 0, z_m}, .strength = strength};
}

// Judged by the truth model: mirror images of charges, not of dipoles.
TEST(CalibrationSteel, SteelResponseMatchesMirrorImages) {
  const base::DeviceGeometry device = support::NominalDevice();
  for (const double z_m : {-0.115, -0.2, -0.4}) {
    sim::RigOptions options;
    sim::Rig without(device, options);
    options.effects.room.steel = {PlaneAt(z_m, 0.7)};
    sim::Rig with(device, options);
    base::Calibration exact = with.ExactCalibration();
    exact.steel = {0.7, z_m};
    const tracker::Model model = tracker::MakeModel(exact);
    sim::Random random(4);
    for (int n = 0; n < 20; ++n) {
      const sim::MagnetPose pose = with.DrawPose({}, random);
      const sim::SensorFields all = with.Readings(&pose, {}), direct = without.Readings(&pose, {});
      const tracker::LocalField steel_T =
          tracker::SteelResponseOf(model, {base::ToEigen(pose.centre_base_m), base::ToEigen(pose.axis_base)}, 1)
              .field_T;
      double error = 0, size = 0;
      for (std::size_t i = 0; i < base::kSensorCount; ++i) {
        const Eigen::Matrix3d gain =
            Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(exact.sensors[i].gain_sensor_base.data());
        const Eigen::Vector3d expected = base::ToEigen(all[i]) - base::ToEigen(direct[i]);
        const Eigen::Vector3d field(steel_T[0][i], steel_T[1][i], steel_T[2][i]);
        error += (gain * field - expected).squaredNorm();
        size += expected.squaredNorm();
      }
      EXPECT_LT(std::sqrt(error / size), 0.01) << z_m << " pose " << n;
    }
  }
}

// Subtracted for a pose half a millimetre and half a degree away from the pen's; the readings are the model's own,
// without noise.
TEST(CalibrationSteel, SteelResponseIsCorrectedForTheFoundPose) {
  base::Calibration calibration = magnetics::NominalCalibration(support::NominalDevice());
  calibration.steel = {1, -0.115};
  const tracker::Model model = tracker::MakeModel(calibration);
  sim::Random random(7);
  for (int n = 0; n < 50; ++n) {
    const auto draw = [&] { return base::ToEigen(random.NormalVector(1)); };
    tracker::Pose pose{{0.02, 0.01, 0.06}, Eigen::Vector3d(-0.3, -0.2, -1).normalized()};
    pose.position_base_m += 0.01 * draw();
    const tracker::Pose expected{pose.position_base_m + 5e-4 * draw().normalized(),
                                 (pose.axis_base + 0.01 * draw().normalized()).normalized()};
    const tracker::SteelResponse is = tracker::SteelResponseOf(model, pose, 1);
    const tracker::SteelResponse taken_off = tracker::SteelResponseOf(model, expected, 1);
    tracker::ModelField field;
    tracker::EvaluateField(model, tracker::MakePosePoint(pose), field);
    base::HallScan scan;
    for (std::size_t i = 0; i < tracker::kSensors; ++i) {
      std::array<double, 3> reading{};
      for (std::size_t axis = 0; axis < 3; ++axis) {
        reading[axis] = field.field_sensor_T[3 * i + axis];
        for (std::size_t c = 0; c < 3; ++c) {
          reading[axis] += model.gain_sensor_base[3 * axis + c][i] * is.field_T[c][i];
        }
      }
      scan.field_sensor_T[i] = {reading[0], reading[1], reading[2]};
    }
    const tracker::Measurement measurement = tracker::MakeMeasurement(
        model, tracker::NoiseOnly(), scan, {}, tracker::UpdatedHistory(scan, {}), {.local_base_T = &taken_off.field_T});
    tracker::Fit fit = tracker::SolvePose(model, measurement, expected, {});
    const double before_m = (fit.pose.position_base_m - pose.position_base_m).norm();
    const double variance_m2 = fit.covariance.diagonal().head(3).sum();
    tracker::CorrectForSteel(model, measurement, expected, taken_off, fit);
    EXPECT_LT((fit.pose.position_base_m - pose.position_base_m).norm(), 0.15 * before_m) << n;
    EXPECT_GT(fit.covariance.diagonal().head(3).sum(), 0.5 * variance_m2);
  }
}

// Any steel was rejected before there was an unknown for it. -115 mm: a steel top right under the base.
TEST(CalibrationSteel, PlaneUnderTheBaseIsFound) {
  base::DeviceGeometry device = support::NominalDevice();
  device.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kUltraHigh);
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  for (const double z_m : {-0.115, -0.15, -0.2, -0.3}) {
    sim::RigOptions options{.seed = 51, .noise = sim::NoiseMode::kUltraHigh};
    options.sizes.sensor_position_m = 1e-3;
    options.sizes.sensor_gain = 0.015;
    options.sizes.core_offset_m = 3e-4;
    options.effects.room.steel = {PlaneAt(z_m, 1)};
    sim::Rig rig(device, options);
    const auto outcome = calibration::SelfCalibrate(
        nominal, device.coils, test::MakeRecording(rig, {.waves = 300, .touches = 100, .touch_sigma_m = 5e-5}));
    ASSERT_TRUE(outcome.ok()) << z_m << ": " << outcome.error();
    EXPECT_LT(outcome->report.chi2_per_dof, 1.2);
    // Far away, strength and height have the same effect; the field is what matters.
    base::Calibration exact = rig.ExactCalibration();
    exact.steel = {1, z_m};
    const tracker::Model found = tracker::MakeModel(outcome->calibration), true_model = tracker::MakeModel(exact);
    ASSERT_TRUE(tracker::HasSteel(found));
    const tracker::Pose pose{{0.03, 0.02, 0.06}, Eigen::Vector3d(-0.3, -0.2, -1).normalized()};
    const tracker::LocalField is = tracker::SteelResponseOf(found, pose, 1).field_T,
                              was = tracker::SteelResponseOf(true_model, pose, 1).field_T;
    double error = 0, size = 0;
    for (std::size_t c = 0; c < 3; ++c) {
      for (std::size_t i = 0; i < base::kSensorCount; ++i) {
        error += (is[c][i] - was[c][i]) * (is[c][i] - was[c][i]);
        size += was[c][i] * was[c][i];
      }
    }
    EXPECT_LT(std::sqrt(error / size), 0.05) << z_m;
  }
}

TEST(CalibrationSteel, RarelyReportsSteelWithoutSteel) {
  const base::DeviceGeometry device = support::NominalDevice();
  const base::Calibration nominal = magnetics::NominalCalibration(device);
  int found = 0;
  for (const std::uint64_t seed : {61u, 62u, 63u, 64u}) {
    sim::RigOptions options{.seed = seed, .noise = sim::NoiseMode::kUltraHigh};
    options.sizes.sensor_position_m = 1e-3;
    sim::Rig rig(device, options);
    const auto outcome = calibration::SelfCalibrate(nominal, device.coils, test::MakeRecording(rig, {.seed = seed}));
    ASSERT_TRUE(outcome.ok()) << outcome.error();
    found += outcome->calibration.steel.strength != 0 ? 1 : 0;
  }
  EXPECT_LE(found, 1);  // three standard deviations
}

// Every derivative of the steel's response against finite differences.
TEST(CalibrationSteel, DerivativesMatchFiniteDifferences) {
  const base::Calibration nominal = magnetics::NominalCalibration(support::NominalDevice());
  using Eigen::Vector3d;
  const magnetics::DiscMagnet unit = magnetics::MakeDiscMagnet(nominal.magnet, 1);
  const double kappa = nominal.core_kappa, a = nominal.core_radius_m;
  const calibration::ToolFrame tool =
      calibration::MakeToolFrame({0.02, -0.01, 0.07}, Vector3d(0.2, 0.1, -1).normalized());
  const auto at = [&](const Vector3d& place, const calibration::ToolFrame& frame) {
    const calibration::ToolField field = calibration::FieldAtSensor(place, a).Evaluate(unit, kappa, frame);
    calibration::PlacedField<5> whole;
    whole.B = field.direct + kappa * field.image;
    whole.by = field.by_pose;
    whole.by_place = field.by_sensor;
    return whole;
  };
  const auto answer = [&](const Vector3d& s, double height, const calibration::ToolFrame& frame) {
    return calibration::SteelResponseOf(s, a, kappa, at(calibration::MirroredPlace(height, s), frame),
                                        at(calibration::MirroredPlace(height, Vector3d::Zero()), frame));
  };
  const Vector3d s(0.03, 0.035, -0.01);
  const double height = -0.12, step = 1e-6;
  const auto analytic = answer(s, height, tool);
  const double size = analytic.field.by_place.norm();
  for (int c = 0; c < 3; ++c) {
    const Vector3d move = step * Vector3d::Unit(c);
    const Vector3d by_place =
        (answer(s + move, height, tool).field.B - answer(s - move, height, tool).field.B) / (2 * step);
    EXPECT_LT((by_place - analytic.field.by_place.col(c)).norm(), 1e-5 * size);
    calibration::ToolFrame ahead = tool, behind = tool;
    ahead.position_base_m += move;
    behind.position_base_m -= move;
    const Vector3d by_pose = (answer(s, height, ahead).field.B - answer(s, height, behind).field.B) / (2 * step);
    EXPECT_LT((by_pose - analytic.field.by.col(c)).norm(), 1e-5 * size);
  }
  const Vector3d by_height =
      (answer(s, height + step, tool).field.B - answer(s, height - step, tool).field.B) / (2 * step);
  EXPECT_LT((by_height - analytic.by_height).norm(), 1e-5 * size);
}

}  // namespace
}  // namespace omni
