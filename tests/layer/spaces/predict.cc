// Poses from the service's history: past, future, lost, uncertain, gone. Without OpenXR.
#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <glm/geometric.hpp>
#include <memory>
#include <random>

#include "layer/src/spaces/tool_motion.h"
#include "service/ipc/state_publisher.h"
#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_predict {

using layer::Motion;
using layer::Prediction;
using protocol::ToolSample;

constexpr std::int64_t kTick_ns = 1'000'000;
constexpr std::int64_t kNow_ns = 100'000'000'000;
constexpr std::uint32_t kSeenFlags = protocol::kToolPoseValid | protocol::kToolTracked;

ToolSample SampleAt(const PenPath& path, std::int64_t t_ns, std::uint32_t flags = kSeenFlags) {
  ToolSample sample;
  sample.t_ns = t_ns;
  sample.flags = flags;
  Along(path)(sample);
  return sample;
}

// Straight on at `v`.
PenPath Straight(const glm::dvec3& v) {
  return [v](double t_s) {
    Motion m;
    m.X.p = (t_s - 1e-9 * static_cast<double>(kNow_ns)) * v;
    m.v = v;
    return m;
  };
}

// A hand that holds still: 8 Hz of .2 mm, and a little turning to and fro.
Motion Tremor(double t_s) {
  constexpr double kA_m = 2e-4, kW = 2 * 3.14159265358979 * 8;
  Motion m;
  m.X.p = {kA_m * std::sin(kW * t_s), 0, 0};
  m.v = {kA_m * kW * std::cos(kW * t_s), 0, 0};
  m.X.q = layer::ExpRotation({0.002 * std::sin(kW * t_s), 0, 0});
  m.w = {0.002 * kW * std::cos(kW * t_s), 0, 0};
  return m;
}

Motion PredictOn(const PenPath& path, std::int64_t t_ns, std::int64_t ahead_ns,
                 Prediction method = Prediction::kTrusted) {
  return layer::Predict(SampleAt(path, t_ns), SampleAt(path, t_ns - layer::kTrendSamples * kTick_ns), t_ns + ahead_ns,
                        method);
}

TEST(Predict, MovingHandIsExtrapolated) {
  const glm::dvec3 v(0.2, -0.1, 0.15);
  const Motion at = PredictOn(Straight(v), kNow_ns, 20 * kTick_ns);
  EXPECT_LT(glm::length(at.X.p - 0.02 * v), 0.01 * 0.02 * glm::length(v));
  EXPECT_LT(glm::length(at.v - v), 0.01 * glm::length(v));
}

// The tremor of a resting hand: within its own size of where it is, at every phase, where constant velocity is not.
TEST(Predict, TremorIsNotAmplified) {
  double worst_m = 0, constant_m = 0;
  for (std::int64_t t = 0; t < 125 * kTick_ns; t += 3 * kTick_ns) {
    const Motion hold = PredictOn(Tremor, kNow_ns + t, 40 * kTick_ns, Prediction::kHold);
    const auto leap = [&](Prediction method) {
      return glm::length(PredictOn(Tremor, kNow_ns + t, 40 * kTick_ns, method).X.p - hold.X.p);
    };
    worst_m = std::max(worst_m, leap(Prediction::kTrusted));
    constant_m = std::max(constant_m, leap(Prediction::kConstantVelocity));
  }
  EXPECT_LT(worst_m, 5e-5);
  EXPECT_GT(constant_m, 3e-4);
}

// A slow hand that trembles, with the noise that a tracker's velocity has: closer to the truth than either extreme.
TEST(Predict, BetterThanHoldingAndThanConstantVelocity) {
  std::mt19937 random(9);
  std::normal_distribution<> noise_m_s(0, 0.006);
  for (const std::int64_t ahead_ns : {20 * kTick_ns, 40 * kTick_ns}) {
    double hold = 0, constant = 0, trusted = 0;
    for (std::uint32_t seed = 1; seed <= 300; ++seed) {
      const PenPath hand = RandomPath(seed);
      const PenPath path = [&](double t_s) {
        Motion m = hand(0.05 * t_s);
        const Motion tremor = Tremor(t_s);
        m.X.p += tremor.X.p;
        m.v = 0.05 * m.v + tremor.v;
        m.w *= 0.05;
        return m;
      };
      const std::int64_t t = kNow_ns + 37 * kTick_ns * seed;
      const glm::dvec3 truth = path(1e-9 * static_cast<double>(t + ahead_ns)).X.p;
      ToolSample newest = SampleAt(path, t);
      for (double& v : newest.linear_velocity_base_m_s) v += noise_m_s(random);
      const ToolSample earlier = SampleAt(path, t - layer::kTrendSamples * kTick_ns);
      const auto square = [&](Prediction method) {
        const glm::dvec3 off = layer::Predict(newest, earlier, t + ahead_ns, method).X.p - truth;
        return glm::dot(off, off);
      };
      hold += square(Prediction::kHold);
      constant += square(Prediction::kConstantVelocity);
      trusted += square(Prediction::kTrusted);
    }
    EXPECT_LT(trusted, constant) << ahead_ns;
    EXPECT_LT(trusted, hold) << ahead_ns;
  }
}

// Never further than constant velocity leads, and in its direction; the velocity is that of the pose.
TEST(Predict, NeverExceedsConstantVelocityPrediction) {
  for (std::uint32_t seed = 1; seed <= 200; ++seed) {
    const PenPath path = RandomPath(seed);
    const Motion now = PredictOn(path, kNow_ns, 0);
    const Motion before = PredictOn(path, kNow_ns, 14 * kTick_ns);
    const Motion at = PredictOn(path, kNow_ns, 15 * kTick_ns);
    const Motion after = PredictOn(path, kNow_ns, 16 * kTick_ns);
    const Motion truth = path(1e-9 * static_cast<double>(kNow_ns));
    const glm::dvec3 way = at.X.p - now.X.p;
    EXPECT_LE(glm::length(way), 0.015 * glm::length(truth.v) * 1.0001);
    EXPECT_GT(glm::dot(way, truth.v), 0);
    EXPECT_LT(glm::length((after.X.p - before.X.p) / 0.002 - at.v), 1e-6 * glm::length(at.v));
    const glm::dquat turn = after.X.q * glm::conjugate(before.X.q);
    EXPECT_LT(glm::length(glm::dvec3(turn.x, turn.y, turn.z) / 0.001 - at.w), 1e-3 * glm::length(at.w));
  }
}

// Without a usable earlier sample the newest velocity replaces the mean.
TEST(Predict, WithoutTrendNewestVelocityIsUsed) {
  const PenPath path = Straight({0.1, 0, 0});
  const ToolSample newest = SampleAt(path, kNow_ns);
  ToolSample invalid = SampleAt(path, kNow_ns - 100 * kTick_ns, 0);
  invalid.position_base_m = newest.position_base_m;  // as if it had not moved
  ToolSample near = SampleAt(path, kNow_ns - 5 * kTick_ns);
  near.position_base_m = newest.position_base_m;
  ToolSample far = SampleAt(path, kNow_ns - 1000 * kTick_ns);
  far.position_base_m = newest.position_base_m;
  for (const ToolSample& earlier : {invalid, near, far, newest})
    EXPECT_NEAR(layer::Predict(newest, earlier, kNow_ns + 10 * kTick_ns).X.p.x, 0.001, 2e-5);
}

// A ring of the service, filled as the test says.
class History : public testing::Test {
 protected:
  void SetUp() override {
    auto made = ipc::StatePublisher::Create(1);
    ASSERT_TRUE(made.ok()) << made.error();
    publisher = std::move(made.value());
    auto mapped = client::StateReader::Map(base::UniqueFd(dup(publisher->fd())), sizeof(protocol::StateMemory));
    ASSERT_TRUE(mapped.ok()) << mapped.error();
    reader = *mapped;
  }
  void Add(const ToolSample& sample) { publisher->Publish(sample, protocol::InputSnapshot{}); }
  // `count` samples of `path`, the last one `ago_ms` before kNow_ns.
  void Fill(const PenPath& path, int count, std::uint32_t flags = kSeenFlags, int ago_ms = 0) {
    for (int i = ago_ms + count - 1; i >= ago_ms; --i) Add(SampleAt(path, kNow_ns - i * kTick_ns, flags));
  }
  layer::ToolMotion At(std::int64_t ago_ns) const { return layer::ToolMotionAt(*reader, kNow_ns - ago_ns, kNow_ns); }

  std::unique_ptr<ipc::StatePublisher> publisher;
  std::shared_ptr<const client::StateReader> reader;
};

// [fundamentals-prediction-time-limits] at least 50 ms of history; ours is 250 ms and more.
TEST_F(History, PosesAreExactForAtLeast250Milliseconds) {
  const PenPath path = RandomPath(11);
  Fill(path, 600);
  for (std::int64_t ago = 0; ago <= 400 * kTick_ns; ago += 7'300'000) {
    const layer::ToolMotion at = At(ago);
    ASSERT_TRUE(at.valid && at.tracked) << ago;
    const Motion truth = path(1e-9 * static_cast<double>(kNow_ns - ago));
    EXPECT_LT(glm::length(at.X_BT.X.p - truth.X.p), 1e-8);
    EXPECT_LT(Angle(at.X_BT.X.q, truth.X.q), 1e-5);
  }
}

// Before the history: the oldest pose, not TRACKED.
TEST_F(History, PoseBeforeHistoryIsValidButNotTracked) {
  Fill(RandomPath(12), 600);
  const layer::ToolMotion oldest = At(510 * kTick_ns);
  const layer::ToolMotion before = At(5'000 * kTick_ns);
  EXPECT_TRUE(oldest.tracked);
  EXPECT_TRUE(before.valid);
  EXPECT_FALSE(before.tracked);
  EXPECT_FALSE(At(511 * kTick_ns).tracked) << "not by a millisecond";
  EXPECT_LT(glm::length(before.X_BT.X.p - oldest.X_BT.X.p), 1e-9);
}

// [xrLocateSpace] never seen: no VALID at all. Lost: the last pose stays VALID, TRACKED goes.
TEST_F(History, NeverSeenPoseIsInvalidAndLostPoseIsNotTracked) {
  EXPECT_FALSE(At(0).valid) << "nothing published yet";
  Fill(Lissajous, 10, 0, 20);
  EXPECT_FALSE(At(0).valid);
  EXPECT_FALSE(At(-20 * kTick_ns).valid);
  Fill(Lissajous, 10, protocol::kToolPoseValid);
  for (const std::int64_t ago : {std::int64_t{0}, 3 * kTick_ns, -20 * kTick_ns}) {
    EXPECT_TRUE(At(ago).valid);
    EXPECT_FALSE(At(ago).tracked);
  }
}

// A measured pose stays TRACKED at its time, also after the pen was lost.
TEST_F(History, PoseBeforeTrackingLossStaysTracked) {
  for (int i = 200; i > 20; --i) Add(SampleAt(Lissajous, kNow_ns - i * kTick_ns));
  for (int i = 20; i >= 0; --i) Add(SampleAt(Lissajous, kNow_ns - i * kTick_ns, protocol::kToolPoseValid));
  EXPECT_TRUE(At(100 * kTick_ns).tracked);
  EXPECT_FALSE(At(10 * kTick_ns).tracked);
  EXPECT_TRUE(At(10 * kTick_ns).valid);
}

// An uncertain position: VALID, not TRACKED.
TEST_F(History, UncertainPositionIsNotTracked) {
  const auto tracked = [&](double sigma_m) {
    ToolSample sample = SampleAt(Lissajous, kNow_ns);
    sample.position_sigma_m = sigma_m;
    Add(sample);
    EXPECT_TRUE(At(0).valid);
    return At(0).tracked && At(-10 * kTick_ns).tracked;
  };
  EXPECT_TRUE(tracked(0.9 * layer::kMaxTrackedSigma_m));
  EXPECT_FALSE(tracked(1.1 * layer::kMaxTrackedSigma_m));
  EXPECT_TRUE(tracked(0));
}

// A hole in the history: between its edges nothing was measured.
TEST_F(History, PoseInHistoryGapIsNotTracked) {
  for (int i = 300; i >= 220; --i) Add(SampleAt(Lissajous, kNow_ns - i * kTick_ns));
  for (int i = 20; i >= 0; --i) Add(SampleAt(Lissajous, kNow_ns - i * kTick_ns));
  EXPECT_TRUE(At(230 * kTick_ns).tracked);
  EXPECT_TRUE(At(120 * kTick_ns).valid);
  EXPECT_FALSE(At(120 * kTick_ns).tracked);
  EXPECT_TRUE(At(10 * kTick_ns).tracked);
}

// [CTS ActionSpaces] a device that is gone is not locatable, at once and for any time.
TEST_F(History, PoseIsInvalidAfterPresenceTimeout) {
  Fill(Lissajous, 50);
  const auto at = [&](std::int64_t later_ns) {
    return layer::ToolMotionAt(*reader, kNow_ns + later_ns, kNow_ns + later_ns).valid;
  };
  EXPECT_TRUE(at(layer::kPresenceTimeout_ns));
  EXPECT_FALSE(at(layer::kPresenceTimeout_ns + 1));
}

TEST_F(History, PredictionIsHeldBeyondTheHorizon) {
  Fill(Straight({0.3, 0, 0}), 200);
  const double held_m = At(-layer::kMaxPrediction_ns).X_BT.X.p.x;
  EXPECT_NEAR(held_m, 0.012, 1e-4);
  for (const std::int64_t ahead : {41 * kTick_ns, 1'000 * kTick_ns, std::int64_t{1} << 60})
    EXPECT_EQ(At(-ahead).X_BT.X.p.x, held_m);
}

}  // namespace test_spaces_predict
}  // namespace omni::test
