// The measurement model against magnetics, which shares no code with the hot kernel, and against differences.
#include <gtest/gtest.h>

#include <Eigen/Cholesky>

#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/nominal.h"
#include "service/magnetics/zonal.h"
#include "service/tracker/kernel/linearise.h"
#include "service/tracker/kernel/measurement.h"
#include "service/tracker/tracker.h"
#include "tests/support/core_image.h"
#include "tests/support/rig/magnet_truth.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/tool_scan.h"

namespace omni::tracker {
namespace test_tracker_model {

using Eigen::Vector3d;
using support::RelativeError;
using support::Rng;
using Vector24d = Eigen::Matrix<double, kReadings, 1>;

// Sensors turned every way, so that a transposed rotation cannot hide.
base::DeviceGeometry TurnedDevice(Rng& rng) {
  base::DeviceGeometry device = support::NominalDevice();
  for (auto& sensor : device.sensors) {
    sensor.orientation_base_sensor =
        base::FromEigen(Eigen::Quaterniond(Eigen::AngleAxisd(support::Uniform(rng, -3, 3), support::RandomUnit(rng))));
  }
  return device;
}

Vector24d Field(const Model& model, const PosePoint& point) {
  ModelField field;
  EvaluateField(model, point, field);
  return Eigen::Map<const Vector24d>(field.field_sensor_T.data());
}

// The pose after a turn by `angle` about the tangents, basis carried along with the axis.
PosePoint Moved(const PosePoint& point, int parameter, double step) {
  PosePoint moved = point;
  if (parameter < 3) {
    moved.position_base_m[static_cast<std::size_t>(parameter)] += step;
    return moved;
  }
  const auto& tangent = parameter == 3 ? point.tangent_1_base : point.tangent_2_base;
  auto& carried = parameter == 3 ? moved.tangent_1_base : moved.tangent_2_base;
  for (std::size_t i = 0; i < 3; ++i) {
    moved.axis_base[i] = std::cos(step) * point.axis_base[i] + std::sin(step) * tangent[i];
    carried[i] = std::cos(step) * tangent[i] - std::sin(step) * point.axis_base[i];
  }
  return moved;
}

// Zonal moments of dipoles m_i on the axis at z_i: q_l = l sum m_i z_i^(l-1). Five of them at 0, +-h, +-2 h have the
// tool's q1, q3, q5 and next to nothing beyond; the core's image of each is exact.
std::array<double, 3> AxialMoments(const std::array<double, 3>& zonal, double h) {
  const double third = zonal[1] / (6 * h * h), fifth = zonal[2] / (10 * h * h * h * h);
  const double outer = (fifth - third) / 12;  // m1 + 4 m2 = third, m1 + 16 m2 = fifth
  const double inner = third - 4 * outer;
  return {zonal[0] - 2 * inner - 2 * outer, inner, outer};
}

void ExpectImagesOfDipoles(Rung rung, double tolerance) {
  constexpr double kStep_m = 5e-4;
  Rng rng(1);
  const base::DeviceGeometry device = TurnedDevice(rng);
  const Model model = MakeModel(magnetics::NominalCalibration(device), rung);
  std::array<double, 3> zonal = magnetics::MakeDiscMagnet(device.magnet).zonal;
  if (rung != Rung::kFull) zonal[1] = zonal[2] = 0;
  const std::array<double, 3> moments = AxialMoments(zonal, kStep_m);
  for (int i = 0; i < 300; ++i) {
    const Pose pose = support::RandomPose(rng, model, 0.038, 0.15);
    Vector24d expected;
    for (int s = 0; s < kSensors; ++s) {
      const auto& sensor = device.sensors[static_cast<std::size_t>(s)];
      const Vector3d x = base::ToEigen(sensor.position_base_m);
      Vector3d B = magnetics::ZonalField(zonal, pose.axis_base, x - pose.position_base_m);
      for (int k = -2; k <= 2; ++k) {
        const Vector3d at = pose.position_base_m + k * kStep_m * pose.axis_base;
        const double moment = moments[static_cast<std::size_t>(std::abs(k))];
        B += support::CoreImageField(
            support::ImageInCore(moment * pose.axis_base, at, device.core_radius_m, device.core_kappa), x);
      }
      expected.segment<3>(3 * s) = base::ToEigen(sensor.orientation_base_sensor).conjugate() * B;
    }
    EXPECT_LT(RelativeError(Field(model, MakePosePoint(pose)), expected), tolerance);
  }
}

TEST(TrackerModel, DipoleImageMatchesMagnetics) { ExpectImagesOfDipoles(Rung::kDipoleCore, 1e-12); }
TEST(TrackerModel, MultipoleImageMatchesARowOfDipoleImages) { ExpectImagesOfDipoles(Rung::kFull, 1e-6); }

TEST(TrackerModel, JacobianMatchesFiniteDifferences) {
  Rng rng(2);
  const Model model = MakeModel(magnetics::NominalCalibration(TurnedDevice(rng)));
  for (int i = 0; i < 1000; ++i) {
    const PosePoint point = MakePosePoint(support::RandomPose(rng, model, 0.038, 0.20));
    ModelField field;
    EvaluateField(model, point, field);
    for (int k = 0; k < kParameters; ++k) {
      const double h = k < 3 ? 5e-5 : 1e-3;
      const Vector24d numeric = (8 * (Field(model, Moved(point, k, h)) - Field(model, Moved(point, k, -h))) -
                                 (Field(model, Moved(point, k, 2 * h)) - Field(model, Moved(point, k, -2 * h)))) /
                                (12 * h);
      Vector24d analytic;
      for (std::size_t row = 0; row < kReadings; ++row) {
        analytic[static_cast<int>(row)] = field.jacobian[row][static_cast<std::size_t>(k)];
      }
      ASSERT_LT(RelativeError(analytic, numeric), 1e-6) << "parameter " << k << " pose " << i;
    }
  }
}

// The kernel eliminates the errors of currents and the ambient field; here their covariance is written out, 24 x 24.
TEST(TrackerModel, NormalEquationsMatchTheWhitenedJacobian) {
  Rng rng(3);
  Config config = MakeConfig(TurnedDevice(rng));
  for (int i = 0; i < 200; ++i) {
    config.trust.ambient_error_T = i % 2 == 0 ? 0 : 5e-7;
    const Pose pose = support::RandomPose(rng, config.model, 0.041, 0.12);
    const base::HallScan scan = support::MakeScan(config.model, pose, 0, rng, {.noise_scale = 30});
    Measurement measurement = MakeMeasurement(config.model, config.trust, scan, {}, {});
    measurement.velocity_base_m_s = {0.3, -0.2, 0.5};
    measurement.axis_rate_base_1_s = {1, 2, -1};
    for (std::size_t s = 0; s < kSensors; ++s) measurement.age_s[s] = 1e-4 * static_cast<double>(s);
    const PosePoint point = MakePosePoint(pose);
    NormalEquations equations;
    Linearise(config.model, measurement, point, equations);

    ModelField field;
    EvaluateField(config.model, point, field);
    Eigen::Matrix<double, kReadings, kParameters> J;
    Vector24d r;
    for (std::size_t row = 0; row < kReadings; ++row) {
      const double w = measurement.inverse_sigma[row % 3][row / 3];
      double rate = 0;
      for (std::size_t k = 0; k < kParameters; ++k) {
        J(static_cast<int>(row), static_cast<int>(k)) = w * field.jacobian[row][k];
        double parameter_rate = 0;
        for (std::size_t c = 0; c < 3; ++c) {
          const auto& tangent = k == 3 ? point.tangent_1_base : point.tangent_2_base;
          parameter_rate += k < 3 ? (c == k ? measurement.velocity_base_m_s[c] : 0.0)
                                  : measurement.axis_rate_base_1_s[c] * tangent[c];
        }
        rate += field.jacobian[row][k] * parameter_rate;
      }
      r[static_cast<int>(row)] =
          w * (field.field_sensor_T[row] - rate * measurement.age_s[row / 3]) - measurement.whitened[row % 3][row / 3];
    }
    Eigen::Matrix<double, kReadings, kReadings> C = Eigen::Matrix<double, kReadings, kReadings>::Identity();
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      Vector24d a;
      for (std::size_t row = 0; row < kReadings; ++row) {
        a[static_cast<int>(row)] =
            measurement.inverse_sigma[row % 3][row / 3] * config.model.coil_map_T_A[row * base::kCoilCount + k];
      }
      C += config.trust.current_error_A * config.trust.current_error_A * a * a.transpose();
    }
    for (std::size_t c = 0; c < 3; ++c) {
      Vector24d a;
      for (std::size_t row = 0; row < kReadings; ++row) {
        a[static_cast<int>(row)] =
            measurement.inverse_sigma[row % 3][row / 3] * config.model.gain_sensor_base[3 * (row % 3) + c][row / 3];
      }
      C += config.trust.ambient_error_T * config.trust.ambient_error_T * a * a.transpose();
    }
    const auto solver = C.ldlt();
    using Matrix5 = Eigen::Matrix<double, kParameters, kParameters>;
    using Vector5 = Eigen::Matrix<double, kParameters, 1>;
    const Matrix5 JtJ = J.transpose() * solver.solve(J);
    const Vector5 Jtr = J.transpose() * solver.solve(r);
    const double chi2 = r.dot(solver.solve(r));
    EXPECT_LT(RelativeError(Matrix5(Eigen::Map<const Matrix5>(equations.JtJ.data())), JtJ), 1e-10);
    EXPECT_LT(RelativeError(Vector5(Eigen::Map<const Vector5>(equations.Jtr.data())), Jtr), 1e-8);
    EXPECT_NEAR(equations.chi2, chi2, 1e-9 * chi2);
  }
}

// Charges on the magnet's faces, each with its own image: no multipole, no ring. The position error of the model is
// what a noise-free fit makes of it.
base::HallScan TruthScan(const base::DeviceGeometry& device, const Pose& pose) {
  static const auto kCharges = support::DiscCharges(device.magnet, 8, 12);
  base::HallScan scan;
  const double a = device.core_radius_m;
  for (std::size_t s = 0; s < kSensors; ++s) {
    const Vector3d x = base::ToEigen(device.sensors[s].position_base_m);
    Vector3d B = Vector3d::Zero();
    for (const auto& charge : kCharges) {
      const Vector3d at = support::ChargePosition(charge, pose.position_base_m, pose.axis_base);
      const double q_image = device.core_kappa * charge.q * a / at.norm();
      B += magnetics::ChargeField(charge.q, x - at) -
           magnetics::ChargeField(q_image, x - a * a / at.squaredNorm() * at) + magnetics::ChargeField(q_image, x);
    }
    scan.field_sensor_T[s] = base::FromEigen(B);
  }
  return scan;
}

TEST(TrackerModel, SystematicErrorAgainstChargedFacesIsBelowFortyMicrometres) {
  Rng rng(4);
  const base::DeviceGeometry device = support::NominalDevice();
  const Config config = MakeConfig(device);
  double sum_m = 0, worst_m = 0;
  constexpr int kCount = 300;
  for (int i = 0; i < kCount; ++i) {
    const Pose truth = support::RandomPose(rng, config.model, 0.041, 0.10, std::numbers::pi / 3);
    const Measurement measurement = MakeMeasurement(config.model, config.trust, TruthScan(device, truth), {}, {});
    const Fit fit = SolvePose(config.model, measurement, truth, 0, 20);
    ASSERT_TRUE(fit.converged);
    const double error_m = (fit.pose.position_base_m - truth.position_base_m).norm();
    sum_m += error_m;
    worst_m = std::max(worst_m, error_m);
  }
  EXPECT_LT(sum_m / kCount, 1.5e-5);
  EXPECT_LT(worst_m, 4e-5);
}

// A near pen's field is a reading wherever the sensors reach: 5 mT of a base whose sensors end at 1.6 mT are not.
TEST(TrackerModel, ReadingsAreUsedUpToTheRangeOfTheCalibration) {
  base::Calibration calibration = magnetics::NominalCalibration(support::NominalDevice());
  for (const double range_T : {0.4e-3, 1.6e-3, 20e-3}) {
    calibration.sensor_range_T = range_T;
    const Config config = MakeConfig(calibration);
    support::Rng rng{1};
    base::HallScan scan = support::MakeScan(config.model, {{0, 0, 0.1}, -Vector3d::UnitZ()}, 1'000'000'000, rng);
    for (const double share : {0.9, 3.9, 4.1}) {
      scan.field_sensor_T[0].x = share * range_T;
      const int axes = MakeMeasurement(config.model, config.trust, scan, {}, UpdatedHistory(scan, {})).axes;
      EXPECT_EQ(axes, share > 4 ? kReadings - 1 : kReadings) << range_T << " " << share;
    }
  }
}

}  // namespace test_tracker_model
}  // namespace omni::tracker
