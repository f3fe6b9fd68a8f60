// The tip's position from known poses: what is found, and what is rejected.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "service/base/eigen.h"
#include "service/calibration/checks/tip.h"

namespace omni::calibration {
namespace test_calibration_tip {

using Eigen::Vector3d;

constexpr double kDrawn_m = 0.005, kError_m = 0.1e-3;

// Poses of a pen that leans by up to `lean_rad` about `tip(share of the time)`.
std::vector<PivotPose> Pivot(double tip_offset_m, double lean_rad, const std::function<Vector3d(double)>& tip,
                             std::uint32_t seed, double noise_m = 0.05e-3) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::normal_distribution<double> noise(0, noise_m / std::sqrt(3.0));
  std::vector<PivotPose> poses;
  constexpr int kPoses = 100;
  for (int i = 0; i < kPoses; ++i) {
    const Vector3d u = Vector3d(lean_rad * uniform(random), lean_rad * uniform(random), -1).normalized();
    const Vector3d p =
        tip(static_cast<double>(i) / kPoses) - tip_offset_m * u + Vector3d(noise(random), noise(random), noise(random));
    poses.push_back({base::FromEigen(p), base::FromEigen(u)});
  }
  return poses;
}

Vector3d Dimple(double /*share*/) { return {0.01, -0.07, 0.02}; }

TEST(CalibrationTip, TipIsFoundForAnyDimplePosition) {
  for (std::uint32_t seed = 1; seed <= 100; ++seed) {
    const double true_m = kDrawn_m + 4e-3 * std::sin(seed);
    const Vector3d place(0.1 * std::sin(2.0 * seed), 0.1 * std::cos(3.0 * seed), 0.05);
    const auto tip = FindTip(Pivot(
                                 true_m, 0.5, [&](double) { return place; }, seed),
                             kDrawn_m, kError_m);
    ASSERT_TRUE(tip.ok()) << tip.error();
    EXPECT_NEAR(tip->tip_offset_m, true_m, 4 * 0.05e-3 / 0.4 / 10) << seed;
    EXPECT_NEAR(tip->rms_m, 0.05e-3, 0.015e-3);
    EXPECT_GT(tip->sigma_m, std::abs(tip->tip_offset_m - true_m)) << seed;
  }
}

// The mean of poses while the pen moves belongs to the same tip: p + d u = c is linear.
TEST(CalibrationTip, AveragedPosesGiveTheSameTip) {
  const std::vector<PivotPose> poses = Pivot(0.0063, 0.6, Dimple, 5, 0);
  std::vector<PivotPose> means;
  for (std::size_t i = 0; i + 3 < poses.size(); i += 4) {
    Vector3d p = Vector3d::Zero(), u = Vector3d::Zero();
    for (std::size_t k = i; k < i + 4; ++k) {
      p += base::ToEigen(poses[k].position_base_m) / 4;
      u += base::ToEigen(poses[k].axis_base) / 4;
    }
    means.push_back({base::FromEigen(p), base::FromEigen(u)});
  }
  const auto tip = FindTip(means, kDrawn_m, kError_m);
  ASSERT_TRUE(tip.ok()) << tip.error();
  EXPECT_NEAR(tip->tip_offset_m, 0.0063, 1e-9);
}

TEST(CalibrationTip, RejectsUnusablePivots) {
  const auto slides = [](double share) { return Vector3d(0.01 + 2e-3 * share, -0.07, 0.02); };
  const auto lifted = [](double share) { return Vector3d(0.01, -0.07, share > 0.8 ? 0.03 : 0.02); };
  const auto nowhere = [](double) { return Vector3d(std::nan(""), 0, 0); };
  struct Row {
    std::vector<PivotPose> poses;
    double drawn_m, error_m;
    std::vector<const char*> mentions;
  };
  const Row rows[] = {
      {Pivot(0.005, 0.05, Dimple, 1), kDrawn_m, kError_m, {"leaned by 2 degrees", "limit is 0.2", "further"}},
      {Pivot(0.005, 0, Dimple, 1), kDrawn_m, kError_m, {"leaned by 0 degrees"}},
      {Pivot(0.005, 0.5, slides, 1), kDrawn_m, kError_m, {"moved by 0.5", "limit is 0.3", "slid"}},
      {Pivot(0.005, 0.5, lifted, 1), kDrawn_m, kError_m, {"moved by", "slid"}},
      {Pivot(0.005, 0.5, nowhere, 1), kDrawn_m, kError_m, {"not measured"}},
      {Pivot(0.005, 0.5, Dimple, 1), kDrawn_m, 0.8e-3, {"errors of 0.80 mm", "--replace"}},
      {Pivot(0.0105, 0.5, Dimple, 1),
       kDrawn_m,
       kError_m,
       {"from the magnet's centre", "says 5.00", "limit is 5", "--device-file"}},
      {Pivot(-0.001, 0.5, Dimple, 1), 0.002, kError_m, {"-1.0", "nothing else of the pen"}}};
  for (const Row& row : rows) {
    const auto tip = FindTip(row.poses, row.drawn_m, row.error_m);
    ASSERT_FALSE(tip.ok()) << row.mentions.front();
    EXPECT_EQ(tip.error().rfind("tip not measured: ", 0), 0U) << tip.error();
    for (const char* words : row.mentions) EXPECT_NE(tip.error().find(words), std::string::npos) << tip.error();
  }
}

}  // namespace test_calibration_tip
}  // namespace omni::calibration
