// Recordings with known poses through the offline tracker.
#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>
#include <sstream>

#include "service/base/eigen.h"
#include "service/config/files/device_file.h"
#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/nominal.h"
#include "service/tools/track/track.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/rig.h"

namespace omni::tools {
namespace test_tools_track_run {

using Eigen::Vector3d;

struct Made {
  base::Calibration array;
  Recording recording;
  Truth truth;
};

// A magnet that is exactly a cylinder over a patch of `count` sensors that stand at random.
Made MakePatch(int count, int poses, double noise_T, std::uint64_t seed) {
  support::Rng rng(seed);
  std::normal_distribution<double> normal;
  Made made;
  made.array.device = "patch";
  made.array.magnet = {.radius_m = 0.005, .half_height_m = 0.004, .remanence_T = 1.3};
  made.array.moment_Am2 = magnetics::MomentOf(made.array.magnet);
  made.array.sensor_noise_T.fill(noise_T > 0 ? noise_T : 1e-7);
  const Vector3d centre(0.6, -0.2, 0.7);
  for (int i = 0; i < count; ++i) {
    base::SensorCalibration sensor;
    const int column_of_4 = i % 4, row_of_4 = i / 4;
    sensor.position_base_m = base::FromEigen(centre + Vector3d(0.015 * column_of_4 - 0.0225, 0.015 * row_of_4 - 0.0225,
                                                               0.004 * support::Uniform(rng, -1, 1)));
    const Eigen::Matrix3d R =
        Eigen::Quaterniond(normal(rng), normal(rng), normal(rng), normal(rng)).normalized().toRotationMatrix();
    for (std::size_t row = 0; row < 3; ++row) {
      for (std::size_t column = 0; column < 3; ++column) {
        sensor.gain_sensor_base[3 * row + column] = 1.03 * R(static_cast<int>(row), static_cast<int>(column));
      }
    }
    sensor.background_sensor_T = {2e-5, -1e-5, 3e-5};
    made.array.sensors.push_back(sensor);
  }
  for (int n = 0; n < poses; ++n) {
    const Vector3d p = centre + Vector3d(support::Uniform(rng, -0.02, 0.02), support::Uniform(rng, -0.02, 0.02),
                                         support::Uniform(rng, 0.035, 0.07));
    const Vector3d u = support::RandomUnit(rng);
    RecordedPose pose{.number = static_cast<std::size_t>(n), .field_sensor_T = {}};
    for (const base::SensorCalibration& sensor : made.array.sensors) {
      const Vector3d B = magnetics::CylinderField(made.array.magnet, u, base::ToEigen(sensor.position_base_m) - p);
      const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> gain(sensor.gain_sensor_base.data());
      const Vector3d noise(normal(rng), normal(rng), normal(rng));
      pose.field_sensor_T.push_back(
          base::FromEigen(gain * B + base::ToEigen(sensor.background_sensor_T) + noise_T * noise));
    }
    made.recording.poses.push_back(pose);
    made.truth[pose.number] = {base::FromEigen(p), base::FromEigen(u)};
  }
  return made;
}

TEST(TrackRun, FindsCylinderWith4To64Sensors) {
  for (const int count : {4, 7, 16, 64}) {
    const Made made = MakePatch(count, 40, 0, 500 + static_cast<std::uint64_t>(count));
    const auto rows = TrackRecording(made.array, made.recording, {.chi2_max = 1e9});
    ASSERT_TRUE(rows.ok()) << rows.error();
    const Rows errors = TrackErrors(*rows, made.truth);
    EXPECT_EQ(errors[0].at("n"), 40) << count;
    EXPECT_LT(errors[0].at("p95_mm").get<double>(), 0.02) << count;
    EXPECT_LT(errors[0].at("orientation_p95_deg").get<double>(), 0.05) << count;
  }
}

TEST(TrackRun, ColdAndWarmStartsAgreeWithConsistentCovariance) {
  const Made made = MakePatch(16, 150, 2e-6, 77);
  const auto rows = TrackRecording(made.array, made.recording, {});
  ASSERT_TRUE(rows.ok()) << rows.error();
  double nees = 0;
  for (const TrackedRow& row : *rows) {
    EXPECT_TRUE(row.same) << row.number;
    EXPECT_STREQ(row.cold.status, "found");
    EXPECT_EQ(row.cold.dof, 43);
    Eigen::Matrix3d P;
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t k = 0; k < 3; ++k) P(static_cast<int>(i), static_cast<int>(k)) = row.cold.covariance[5 * i + k];
    }
    const Vector3d e =
        base::ToEigen(row.cold.position_base_m) - base::ToEigen(made.truth.at(row.number).position_base_m);
    nees += e.dot(P.inverse() * e) / 3 / static_cast<double>(rows->size());
    EXPECT_NEAR(row.cold.residual_rms_T / 2e-6, 1, 0.4);
  }
  EXPECT_NEAR(nees, 1, 0.25);  // 3 sigma of 150 poses: 0.2
}

TEST(TrackRun, TracksBaseWithMeasuredAndHiddenCurrents) {
  sim::Rig rig(config::DefaultDevice(), {.seed = 41, .noise = sim::NoiseMode::kUltraHigh});
  sim::Random random(42);
  Recording recording{.poses = {}, .has_currents = true};
  Truth truth;
  for (std::size_t n = 0; n < 60; ++n) {
    const sim::MagnetPose pose = rig.DrawPose({}, random);
    const sim::CoilArray current_A{random.Uniform(-4, 4), random.Uniform(-4, 4), random.Uniform(-4, 4)};
    const base::HallScan scan = rig.Scan(&pose, current_A, random);
    recording.poses.push_back({.number = n,
                               .field_sensor_T = {scan.field_sensor_T.begin(), scan.field_sensor_T.end()},
                               .current_A = current_A});
    truth[n] = {pose.centre_base_m, pose.axis_base};
  }
  const auto reported = TrackRecording(rig.ExactCalibration(), recording, {});
  const auto hidden = TrackRecording(rig.ExactCalibration(), recording, {.currents = TrackCurrents::kHidden});
  ASSERT_TRUE(reported.ok() && hidden.ok());
  const double reported_mm = TrackErrors(*reported, truth)[0].at("mean_mm"),
               hidden_mm = TrackErrors(*hidden, truth)[0].at("mean_mm");
  EXPECT_LT(reported_mm, 0.25);
  EXPECT_LT(hidden_mm, 0.6);
  EXPECT_GT(hidden_mm, reported_mm);
}

TEST(TrackRun, FilesHaveOneLinePerPose) {
  const Made made = MakePatch(5, 3, 1e-7, 9);
  const auto rows = TrackRecording(made.array, made.recording, {});
  ASSERT_TRUE(rows.ok()) << rows.error();
  std::istringstream text(WritePoses(*rows));
  std::string header, line;
  std::getline(text, header);
  const auto commas = std::count(header.begin(), header.end(), ',');
  int lines = 0;
  for (; std::getline(text, line); ++lines) EXPECT_EQ(std::count(line.begin(), line.end(), ','), commas);
  EXPECT_EQ(lines, 3);
  const std::string residuals = WriteResiduals(*rows);
  EXPECT_EQ(std::count(residuals.begin(), residuals.end(), '\n'), 1 + 3 * 5);
}

}  // namespace test_tools_track_run
}  // namespace omni::tools
