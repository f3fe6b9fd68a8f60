// A base that something carries: poses and velocities of the pen at past, present and predicted times, a source that is
// lost, silent or leaps.
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <glm/geometric.hpp>
#include <memory>
#include <random>
#include <vector>

#include "layer/src/spaces/base_pose.h"
#include "tests/layer/spaces/fixture.h"
#include "tests/layer/support/scene_scenario.h"

namespace omni::test {
namespace test_spaces_moving_base {

using layer::Motion;
using protocol::BaseSample;

constexpr std::int64_t kMs_ns = 1'000'000;
constexpr double kSpeed_m_s = 0.5;
constexpr double kTurn_rad_s = 1.5707963267948966;  // 90 degrees/s

double Seconds(std::int64_t t_ns) { return 1e-9 * static_cast<double>(t_ns); }

// At kSpeed_m_s and kTurn_rad_s from `origin_ns` on: straight on, or on the arc that it turns along.
PenPath Carried(std::uint32_t seed, std::int64_t origin_ns) {
  std::mt19937 random(seed);
  std::normal_distribution<> normal;
  const auto direction = [&] { return glm::normalize(glm::dvec3(normal(random), normal(random), normal(random))); };
  const glm::dvec3 ahead = direction();
  const glm::dvec3 axis = direction();
  const glm::dvec3 side = glm::normalize(glm::cross(axis, ahead));
  const glm::dvec3 along = glm::cross(side, axis);
  const bool arc = seed % 2 == 0;
  return [=](double t_s) {
    const double t = t_s - Seconds(origin_ns);
    const double angle = kTurn_rad_s * t, radius_m = kSpeed_m_s / kTurn_rad_s;
    Motion m;
    m.X.p = arc ? radius_m * (std::sin(angle) * along - std::cos(angle) * side) : kSpeed_m_s * t * ahead;
    m.v = arc ? kSpeed_m_s * (std::cos(angle) * along + std::sin(angle) * side) : kSpeed_m_s * ahead;
    m.w = kTurn_rad_s * axis;
    m.X.q = layer::ExpRotation(angle * axis);
    return m;
  };
}

void Fill(const Motion& m, BaseSample& sample) {
  sample.position_space_m = layer::ToArray(m.X.p);
  sample.orientation_space_wxyz = {m.X.q.w, m.X.q.x, m.X.q.y, m.X.q.z};
  sample.linear_velocity_space_m_s = layer::ToArray(m.v);
  sample.angular_velocity_space_rad_s = layer::ToArray(m.w);
}

FakeService::BaseTrajectory Along(const PenPath& path) {
  return [path](BaseSample& sample) { Fill(path(Seconds(sample.t_ns)), sample); };
}

Motion Resting(double /*t_s*/) {
  Motion m;
  m.X.p = {0.03, -0.02, 0.12};
  m.X.q = layer::ExpRotation({0.3, -0.5, 0.2});
  return m;
}

// The whole layer, with a service whose base moves.
class MovingBase : public SpacesTest {
 protected:
  void Begin(const PenPath& pen_path, FakeService::BaseTrajectory base) {
    Start(app, pen_path);
    ForgetOldPath(app);
    service.MoveBase(std::move(base));
    Settle();
  }
  // What the service says now has reached the layer, and its history is of now.
  void Settle() {
    ForgetOldPath(app);
    ForgetOldPath(app);
  }
  // What is seen `ahead_ns` from now; once more if this computer was away between the service's pose and the answer.
  Seen At(std::int64_t ahead_ns, std::int64_t& t_ns) {
    for (int attempt = 0; attempt < 50; ++attempt) {
      service.Fill();
      const std::int64_t now_ns = Now_ns();
      t_ns = now_ns + ahead_ns;
      const Seen seen = Locate(pen, local, t_ns);
      if (Now_ns() - now_ns < 10 * kMs_ns) return seen;
    }
    ADD_FAILURE() << "this computer is too busy";
    return {};
  }
  void ExpectFlags(XrSpaceLocationFlags flags, std::int64_t ahead_ns) {
    std::int64_t t_ns = 0;
    EXPECT_EQ(At(ahead_ns, t_ns).location.locationFlags, flags) << ahead_ns;
  }
  App app;
};

TEST_F(MovingBase, PenIsWithinAMillimetreOfTheTruth) {
  const std::int64_t origin_ns = Now_ns();
  Begin(Resting, Along(Carried(1, origin_ns)));
  double worst_m = 0;
  for (std::uint32_t seed = 1; seed <= 8; ++seed) {
    const PenPath base = Carried(seed, origin_ns);
    service.MoveBase(Along(base));
    Settle();
    for (std::int64_t ahead_ns = -120 * kMs_ns; ahead_ns <= 30 * kMs_ns; ahead_ns += 5 * kMs_ns) {
      std::int64_t t_ns = 0;
      const Seen seen = At(ahead_ns, t_ns);
      ASSERT_EQ(seen.location.locationFlags, kSeen) << ahead_ns;
      const Motion truth = layer::Compose(base(Seconds(t_ns)), Resting(0));
      worst_m = std::max(worst_m, glm::length(seen.p() - truth.X.p));
      EXPECT_LT(glm::length(seen.p() - truth.X.p), 1e-3) << "seed " << seed << ", ahead " << ahead_ns;
      EXPECT_LT(Angle(seen.q(), truth.X.q), 1e-3);
      // Through the lever of 0.13 m too; on an arc the newest velocity is 40 ms old at most.
      EXPECT_LT(glm::length(seen.v() - truth.v), ahead_ns < -12 * kMs_ns ? 1e-3 : 0.04) << "ahead " << ahead_ns;
      EXPECT_LT(glm::length(seen.w() - truth.w), 1e-3);
    }
  }
  std::printf("[ figure   ] base at 0.5 m/s and 90 degrees/s: pen off by %.2f mm at most\n", 1e3 * worst_m);
}

// A pen that moves in a base that moves, at times that were measured; and what is at rest in the room, in the pen's
// space.
TEST_F(MovingBase, MovingPenHasBothMotions) {
  const PenPath base = Carried(2, Now_ns());
  Begin(Lissajous, Along(base));
  for (std::int64_t ahead_ns = -120 * kMs_ns; ahead_ns <= -15 * kMs_ns; ahead_ns += 7 * kMs_ns) {
    std::int64_t t_ns = 0;
    const Seen seen = At(ahead_ns, t_ns);
    ASSERT_EQ(seen.location.locationFlags, kSeen);
    const Motion truth = layer::Compose(base(Seconds(t_ns)), Lissajous(Seconds(t_ns)));
    EXPECT_LT(glm::length(seen.p() - truth.X.p), 1e-4);
    EXPECT_LT(glm::length(seen.v() - truth.v), 2e-3);
    EXPECT_LT(glm::length(seen.w() - truth.w), 2e-3);
    const Seen room = Locate(local, pen, t_ns);
    const Motion inverse = layer::Inverse(truth);
    EXPECT_LT(glm::length(room.p() - inverse.X.p), 1e-3);
    EXPECT_LT(glm::length(room.v() - inverse.v), 5e-3);
  }
}

// A source that is off by no more than so much leaves the pen off by no more than that and a millimetre.
TEST_F(MovingBase, SourcesErrorIsNotAmplified) {
  constexpr double kPosition_m = 1e-3, kAngle_rad = 3e-3, kVelocity_m_s = 0.01, kLever_m = 0.13;
  const PenPath base = Carried(4, Now_ns());
  std::mt19937 random(4);
  std::normal_distribution<> normal;
  const auto off = [&](double by) {
    return by * glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
  };
  Begin(Resting, [&](BaseSample& sample) {
    Motion m = base(Seconds(sample.t_ns));
    m.X.p += off(kPosition_m);
    m.X.q = layer::ExpRotation(off(kAngle_rad)) * m.X.q;
    m.v += off(kVelocity_m_s);
    Fill(m, sample);
  });
  constexpr double kSources_m = kPosition_m + kAngle_rad * kLever_m + kVelocity_m_s * 0.05;
  for (std::int64_t ahead_ns = -120 * kMs_ns; ahead_ns <= 30 * kMs_ns; ahead_ns += kMs_ns) {
    std::int64_t t_ns = 0;
    const Seen seen = At(ahead_ns, t_ns);
    ASSERT_EQ(seen.location.locationFlags, kSeen);
    const Motion truth = layer::Compose(base(Seconds(t_ns)), Resting(0));
    EXPECT_LT(glm::length(seen.p() - truth.X.p), 1e-3 + kSources_m) << ahead_ns;
  }
}

TEST_F(MovingBase, LostSourceClearsTrackedUntilItIsBack) {
  const PenPath base = Carried(1, Now_ns());
  const auto lost = std::make_shared<bool>(false);
  Begin(Resting, [base, lost](BaseSample& sample) {
    Fill(base(Seconds(sample.t_ns)), sample);
    if (*lost) sample.flags = 0;
  });
  ExpectFlags(kSeen, 10 * kMs_ns);
  *lost = true;
  Pause_ms(12);  // the next pose of the source
  for (const std::int64_t ahead_ns : {0 * kMs_ns, 30 * kMs_ns, 500 * kMs_ns}) ExpectFlags(layer::kValid, ahead_ns);
  *lost = false;
  Pause_ms(12);
  ExpectFlags(kSeen, 10 * kMs_ns);
}

TEST_F(MovingBase, WithoutAPoseOfItThePenIsNotTracked) {
  Begin(Resting, nullptr);
  ExpectFlags(layer::kValid, 0);
}

// The base stands still again: its measured place holds, to the last bit, whatever poses of it there were.
TEST_F(MovingBase, BaseAtRestIsWhereItWasMeasuredToTheLastBit) {
  Start(app, Resting);
  const std::int64_t t_ns = Now_ns() - 20 * kMs_ns;
  const Seen before = Locate(pen, local, t_ns);
  service.MoveBase(Along(Carried(1, t_ns)));
  Settle();
  std::int64_t moving_ns = 0;
  EXPECT_GT(glm::length(At(0, moving_ns).p() - before.p()), 0.05);
  service.SetBasePose(InFrontOfLocal());
  Settle();
  std::int64_t again_ns = 0;
  const Seen again = At(-20 * kMs_ns, again_ns);
  EXPECT_EQ(std::memcmp(&again.location.pose, &before.location.pose, sizeof(XrPosef)), 0);
  EXPECT_EQ(again.location.locationFlags, before.location.locationFlags);
  EXPECT_EQ(std::memcmp(&again.velocity.linearVelocity, &before.velocity.linearVelocity, sizeof(XrVector3f)), 0);
}

// A scene that an application placed in the room stays there: in the base's frame it moves as the base does not.
TEST(MovingBaseScene, SceneInTheRoomStaysWhereItIs) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  const PenPath base = Carried(1, Now_ns());
  scenario.service->MoveBase(Along(base));
  const glm::dvec3 p_L(0.1, 0.2, -0.3);
  const XrHapticScenePlacementOMNIX1 placement{XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1, nullptr,
                                               scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL),
                                               layer::ToXr(layer::Pose{p_L, {1, 0, 0, 0}}), 1};
  ASSERT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  const auto stays = [&] {
    XrFrameState state{XR_TYPE_FRAME_STATE};
    EXPECT_EQ(xrWaitFrame(scenario.app->session, nullptr, &state), XR_SUCCESS);
    EXPECT_GE(xrBeginFrame(scenario.app->session, nullptr), XR_SUCCESS);
    const XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO,           nullptr, state.predictedDisplayTime,
                             XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0,       nullptr};
    EXPECT_EQ(xrEndFrame(scenario.app->session, &end), XR_SUCCESS);
    const std::vector<protocol::HapticScenePlace> places = scenario.service->heard().scene_places;
    if (places.empty()) return false;
    const protocol::HapticScenePlace& place = places.back();
    const Motion scene_in_base =
        layer::Compose(layer::Inverse(base(Seconds(place.t_ns))), MotionOf({p_L, glm::dquat(1, 0, 0, 0)}));
    const auto& p = place.pose.position_m;
    const auto& v = place.pose.velocity_m_s;
    return glm::length(glm::dvec3(p[0], p[1], p[2]) - scene_in_base.X.p) < 1e-3 &&
           glm::length(glm::dvec3(v[0], v[1], v[2]) - scene_in_base.v) < 1e-2;
  };
  EXPECT_TRUE(scenario.Until(stays)) << "within a few frames";
}

// The ring alone, at times that the test says.
class BaseRing : public testing::Test {
 protected:
  static constexpr std::int64_t kNow_ns = 100'000'000'000;
  static constexpr std::int64_t kPeriod_ns = 10 * kMs_ns;

  void SetUp() override {
    auto made = ipc::StatePublisher::Create(1);
    ASSERT_TRUE(made.ok()) << made.error();
    publisher = std::move(made.value());
    auto mapped = client::StateReader::Map(base::UniqueFd(dup(publisher->fd())), sizeof(protocol::StateMemory));
    ASSERT_TRUE(mapped.ok()) << mapped.error();
    reader = *mapped;
  }
  void Add(std::int64_t t_ns, const glm::dvec3& offset = {}, std::uint32_t flags = protocol::kBaseSeen) {
    BaseSample sample;
    sample.t_ns = t_ns;
    Fill(path(Seconds(t_ns)), sample);
    for (std::size_t i = 0; i < 3; ++i) sample.position_space_m[i] += offset[static_cast<int>(i)];
    sample.flags = flags;
    publisher->PublishBase(sample);
  }
  // `count` poses up to kNow_ns.
  void AddMany(int count) {
    for (int i = count - 1; i >= 0; --i) Add(kNow_ns - i * kPeriod_ns);
  }
  layer::BaseMotion At(std::int64_t t_ns, std::int64_t now_ns) const {
    return layer::BaseMotionAt(*reader, t_ns, now_ns);
  }

  const PenPath path = Carried(1, kNow_ns);
  std::unique_ptr<ipc::StatePublisher> publisher;
  std::shared_ptr<const client::StateReader> reader;
};

TEST_F(BaseRing, NothingIsKnownBeforeTheFirstPose) { EXPECT_FALSE(At(kNow_ns, kNow_ns).valid); }

// Two frames at 45 Hz: not a frame later, whatever time is queried.
TEST_F(BaseRing, SilentSourceIsLostAfterTwoFrames) {
  AddMany(5);
  for (const std::int64_t ahead_ns : {0 * kMs_ns, 20 * kMs_ns, 1000 * kMs_ns}) {
    const std::int64_t silent_ns = 2'000'000'000 / 45;
    EXPECT_TRUE(At(kNow_ns + ahead_ns, kNow_ns + silent_ns).tracked);
    EXPECT_FALSE(At(kNow_ns + ahead_ns, kNow_ns + silent_ns + 1).tracked);
    EXPECT_TRUE(At(kNow_ns + ahead_ns, kNow_ns + 3600 * 1000 * kMs_ns).valid);
  }
  EXPECT_TRUE(At(kNow_ns - 1, kNow_ns + 500 * kMs_ns).tracked) << "it was seen then";
}

TEST_F(BaseRing, PredictionIsHeldBeyondItsHorizon) {
  AddMany(5);
  const glm::dvec3 held = At(kNow_ns + layer::kMaxBasePrediction_ns, kNow_ns).X_LO.X.p;
  EXPECT_NEAR(glm::length(held - path(Seconds(kNow_ns)).X.p), 0.025, 1e-9);
  for (const std::int64_t ahead_ns : {51 * kMs_ns, 1000 * kMs_ns, std::int64_t{1} << 60})
    EXPECT_EQ(glm::length(At(kNow_ns + ahead_ns, kNow_ns).X_LO.X.p - held), 0);
}

TEST_F(BaseRing, TimeInAGapIsNotTracked) {
  Add(kNow_ns - 200 * kMs_ns);
  Add(kNow_ns - layer::kMaxBaseGap_ns - kMs_ns);
  Add(kNow_ns - kMs_ns);
  Add(kNow_ns);
  EXPECT_FALSE(At(kNow_ns - 100 * kMs_ns, kNow_ns).tracked);
  EXPECT_TRUE(At(kNow_ns - 20 * kMs_ns, kNow_ns).tracked);
  EXPECT_FALSE(At(kNow_ns - 201 * kMs_ns, kNow_ns).tracked) << "before the oldest";
}

// A leap of 1 m: not TRACKED from the pose before it until one continues it, and never anywhere between.
TEST_F(BaseRing, LeapIsNeverInterpolatedThrough) {
  const glm::dvec3 leap(0.6, 0, 0.8);
  AddMany(10);
  const std::int64_t leapt_ns = kNow_ns + kPeriod_ns;
  Add(leapt_ns, leap, protocol::kBaseSeen | protocol::kBaseLeapt);
  const auto expect_places = [&](std::int64_t now_ns) {
    for (std::int64_t t_ns = kNow_ns - 30 * kMs_ns; t_ns <= now_ns + 40 * kMs_ns; t_ns += kMs_ns / 2) {
      const layer::BaseMotion at = At(t_ns, now_ns);
      ASSERT_TRUE(at.valid);
      const glm::dvec3 truth = path(Seconds(t_ns)).X.p;
      const double off_m = std::min(glm::length(at.X_LO.X.p - truth), glm::length(at.X_LO.X.p - truth - leap));
      EXPECT_LT(off_m, 0.03) << "half way there at " << Seconds(t_ns - kNow_ns) << " s";
    }
  };
  expect_places(leapt_ns);
  EXPECT_TRUE(At(kNow_ns - kMs_ns, leapt_ns).tracked);
  EXPECT_FALSE(At(kNow_ns + kMs_ns, leapt_ns).tracked);
  EXPECT_FALSE(At(leapt_ns, leapt_ns).tracked);
  EXPECT_FALSE(At(leapt_ns + 20 * kMs_ns, leapt_ns).tracked);
  Add(leapt_ns + kPeriod_ns, leap);
  expect_places(leapt_ns + kPeriod_ns);
  EXPECT_FALSE(At(kNow_ns + kMs_ns, leapt_ns + kPeriod_ns).tracked);
  const std::int64_t then_ns = leapt_ns + kPeriod_ns + 20 * kMs_ns;
  const layer::BaseMotion there = At(then_ns, leapt_ns + kPeriod_ns);
  EXPECT_TRUE(there.tracked);
  EXPECT_LT(glm::length(there.X_LO.X.p - path(Seconds(then_ns)).X.p - leap), 1e-6);
}

}  // namespace test_spaces_moving_base
}  // namespace omni::test
