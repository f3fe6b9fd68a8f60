// Poses that an application sends now and then, followed tick by tick: continuous, bounded in speed, at rest when
// stale.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "service/base/eigen.h"
#include "service/loop/scene_motion.h"

namespace omni::loop {
namespace test_loop_pose_track {

constexpr std::int64_t kMs = 1'000'000;

double Angle(const base::Quat& a, const base::Quat& b) { return base::ToEigen(a).angularDistance(base::ToEigen(b)); }

// A body on a Lissajous figure that turns; exact.
PoseSample Truth(double t_s) {
  const double w = 2 * 3.14159265358979 * 0.5;
  PoseSample sample;
  sample.position_m = {0.02 * std::sin(w * t_s), 0.02 * std::cos(w * t_s), 0.01 * std::sin(2 * w * t_s)};
  sample.velocity_m_s = {0.02 * w * std::cos(w * t_s), -0.02 * w * std::sin(w * t_s), 0.02 * w * std::cos(2 * w * t_s)};
  sample.angular_velocity_rad_s = {0.3, 0, 1.0};
  const Eigen::Vector3d axis(0.3, 0, 1.0);
  sample.rotation = base::FromEigen(Eigen::Quaterniond(Eigen::AngleAxisd(axis.norm() * t_s, axis.normalized())));
  return sample;
}

TEST(PoseTrack, FollowsA90HzPoseStreamWithin20Micrometres) {
  PoseTrack track;
  std::uint64_t number = 0;
  double error_m = 0, error_rad = 0, velocity_m_s = 0;
  std::int64_t next_ns = 0;
  for (std::int64_t t_ns = 0; t_ns < 2000 * kMs; t_ns += kMs) {
    if (t_ns >= next_ns) {
      next_ns += 11 * kMs + 111'111;
      PoseSample sample = Truth(1e-9 * static_cast<double>(t_ns + 20 * kMs));  // a frame is shown 20 ms later
      sample.t_ns = t_ns + 20 * kMs;
      sample.number = ++number;
      AddPoseSample(sample, t_ns, track);
    }
    if (t_ns < 100 * kMs) continue;
    const TrackedPose pose = PoseAt(track, t_ns);
    const PoseSample truth = Truth(1e-9 * static_cast<double>(t_ns));
    error_m = std::max(error_m, Distance(pose.position_m, truth.position_m));
    error_rad = std::max(error_rad, Angle(pose.rotation, truth.rotation));
    velocity_m_s = std::max(velocity_m_s, Distance(pose.velocity_m_s, truth.velocity_m_s));
  }
  EXPECT_LT(error_m, 20e-6);
  EXPECT_LT(error_rad, 1e-3);
  EXPECT_LT(velocity_m_s, 0.01);
  std::printf("[ figure   ] pose followed at 1 kHz from 90 Hz: largest error %.2f um, %.4f mrad\n", 1e6 * error_m,
              1e3 * error_rad);
}

// Any samples at any time: no step of position in a tick but a leap, and none faster than the bound allows.
TEST(PoseTrack, RandomSamplesGiveAContinuousSpeedLimitedPath) {
  std::mt19937_64 random(77);
  const auto uniform = [&](double a, double b) { return std::uniform_real_distribution<double>(a, b)(random); };
  for (int trial = 0; trial < 60; ++trial) {
    PoseTrack track;
    base::Vec3 last_m = track.to.position_m;
    base::Quat last;
    std::uint64_t number = 0;
    const double reach_m = trial % 2 == 0 ? 0.01 : 0.04;
    for (std::int64_t t_ns = 0; t_ns < 500 * kMs; t_ns += kMs) {
      bool leapt = false;
      if (uniform(0, 1) < 0.15) {
        PoseSample sample;
        sample.number = ++number;
        sample.t_ns = t_ns + static_cast<std::int64_t>(uniform(-200e6, 200e6));
        sample.position_m = {uniform(-reach_m, reach_m), uniform(-reach_m, reach_m), uniform(-reach_m, reach_m)};
        sample.velocity_m_s = {uniform(-3, 3), uniform(-3, 3), uniform(-3, 3)};
        sample.angular_velocity_rad_s = {uniform(-30, 30), uniform(-30, 30), uniform(-30, 30)};
        sample.rotation = base::FromEigen(
            Eigen::Quaterniond(Eigen::AngleAxisd(uniform(-0.2, 0.2), Eigen::Vector3d::Random().normalized())));
        sample.leaps = uniform(0, 1) < 0.05;
        leapt = AddPoseSample(sample, t_ns, track);
      }
      const TrackedPose pose = PoseAt(track, t_ns);
      ASSERT_NEAR(base::ToEigen(pose.rotation).norm(), 1, 1e-9);
      // The path's peak is at most 1.5 x its mean, and what its ends contribute.
      if (!leapt) {
        ASSERT_LT(Distance(pose.position_m, last_m), 1e-3 * (1.5 * kFastestTrack_m_s + 2 * kFastestTrack_m_s)) << t_ns;
        ASSERT_LT(Angle(pose.rotation, last), 1e-3 * (1.5 * kFastestTurn_rad_s + 2 * kFastestTurn_rad_s)) << t_ns;
      }
      last_m = pose.position_m;
      last = pose.rotation;
    }
  }
}

TEST(PoseTrack, ComesToRestWithoutNewSamples) {
  PoseTrack track;
  PoseSample sample;
  sample.number = 1;
  sample.t_ns = 10 * kMs;
  sample.velocity_m_s = {0.2, 0, 0};
  ASSERT_FALSE(AddPoseSample(sample, 0, track));
  const TrackedPose on = PoseAt(track, 40 * kMs), rest = PoseAt(track, 60 * kMs), later = PoseAt(track, 10'000 * kMs);
  EXPECT_NEAR(on.position_m.x, 0.2 * 0.030, 1e-9);
  EXPECT_NEAR(on.velocity_m_s.x, 0.2, 1e-9);
  EXPECT_NEAR(rest.position_m.x, 0.2 * 0.050, 1e-9);
  EXPECT_EQ(rest.position_m, later.position_m);
  EXPECT_EQ(later.velocity_m_s, base::Vec3{});
}

TEST(PoseTrack, LeapsWhenFarOrFlagged) {
  PoseTrack track;
  PoseSample sample;
  sample.number = 1;
  sample.t_ns = 10 * kMs;
  sample.position_m = {0.2, 0, 0};
  EXPECT_TRUE(AddPoseSample(sample, 0, track));
  EXPECT_EQ(PoseAt(track, 0).position_m, sample.position_m);
  EXPECT_FALSE(AddPoseSample(sample, kMs, track)) << "it is not new";
  sample.number = 2;
  sample.position_m.x = 0.201;
  EXPECT_FALSE(AddPoseSample(sample, 20 * kMs, track));
  sample.number = 3;
  sample.position_m.x = 0.202;
  sample.leaps = true;
  EXPECT_TRUE(AddPoseSample(sample, 40 * kMs, track));
  EXPECT_EQ(PoseAt(track, 40 * kMs).position_m, sample.position_m);
}

TEST(PoseTrack, IgnoresInvalidSamples) {
  const double nan = std::nan("");
  PoseTrack track;
  PoseSample good;
  good.number = 1;
  good.position_m = {0.01, 0, 0};
  AddPoseSample(good, 0, track);
  const PoseTrack before = track;
  for (int k = 0; k < 5; ++k) {
    PoseSample bad = good;
    bad.number = 2;
    bad.t_ns = std::numeric_limits<std::int64_t>::min();
    if (k == 0) bad.rotation = {nan, 0, 0, 0};
    if (k == 1) bad.rotation = {0, 0, 0, 0};
    if (k == 2) bad.position_m.y = nan;
    if (k == 3) bad.velocity_m_s.z = std::numeric_limits<double>::infinity();
    if (k == 4) bad.angular_velocity_rad_s.x = nan;
    EXPECT_FALSE(AddPoseSample(bad, 10 * kMs, track));
    EXPECT_EQ(track.number, before.number);
  }
}

}  // namespace test_loop_pose_track
}  // namespace omni::loop
