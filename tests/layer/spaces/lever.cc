// XrSpaceVelocity against central differences of located poses, for every kind of space in every kind of base, over
// random motions of the pen, the head and the other hand's controller.
#include <cmath>
#include <glm/geometric.hpp>
#include <random>

#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_lever {

constexpr std::int64_t kStep_ns = 2'000'000;
constexpr double kTwoSteps_s = 2e-9 * static_cast<double>(kStep_ns);

class SpacesLever : public SpacesTest, public testing::WithParamInterface<int> {
 protected:
  void SetUp() override {
    SpacesTest::SetUp();
    random.seed(static_cast<std::uint32_t>(GetParam()));
    Start(app, RandomPath(static_cast<std::uint32_t>(GetParam())));
    float pose[7], velocity[6];
    Draw(pose, velocity);
    ASSERT_EQ(omni_test_set_head(pose, velocity), 0);
    Draw(pose, velocity);
    ASSERT_EQ(omni_test_set_pose("/user/hand/left/input/grip/pose", pose, velocity), 0);
    spaces = {pen,
              app.ActionSpace(app.pose, app.right, Offset()),
              local,
              app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL, Offset()),
              app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE, Offset()),
              app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW),
              app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW, Offset()),
              app.ActionSpace(app.pose, app.left, Offset())};
    // The head's motion began just now: query times after that.
    const std::int64_t began = Now_ns();
    while (Now_ns() < began + 80'000'000) {
      service.Fill();  // a sample each millisecond and one each time: too often, and the history gets short
      ASSERT_EQ(app.Sync(), XR_SUCCESS);
      const timespec pause{0, 5'000'000};
      nanosleep(&pause, nullptr);
    }
    now = Now_ns() - 20'000'000;
    service.Fill();
  }

  float Uniform(float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); }
  XrPosef Offset() {
    const glm::dquat q = layer::ExpRotation({Uniform(-2, 2), Uniform(-2, 2), Uniform(-2, 2)});
    return layer::ToXr({{Uniform(-1, 1), Uniform(-1, 1), Uniform(-1, 1)}, q});
  }
  void Draw(float pose[7], float velocity[6]) {
    const XrPosef drawn = Offset();
    const float values[7] = {drawn.position.x,    drawn.position.y,    drawn.position.z,   drawn.orientation.x,
                             drawn.orientation.y, drawn.orientation.z, drawn.orientation.w};
    std::copy_n(values, 7, pose);
    for (int i = 0; i < 3; ++i) velocity[i] = Uniform(-1, 1);
    for (int i = 3; i < 6; ++i) velocity[i] = Uniform(-3, 3);
  }

  App app;
  std::mt19937 random;
  std::vector<XrSpace> spaces;  // the first two are the pen's
  std::int64_t now = 0;
};

glm::dvec3 TurnRate(const glm::dquat& before, const glm::dquat& after) {
  glm::dquat turn = after * glm::conjugate(before);
  if (turn.w < 0) turn = -turn;
  return 2.0 / kTwoSteps_s * glm::dvec3(turn.x, turn.y, turn.z);  // sin(a/2) = a/2
}

// [xrLocateSpace] linearVelocity is of the space's origin, both velocities are relative to the base and in its axes.
TEST_P(SpacesLever, VelocityIsTheDerivativeOfThePose) {
  for (std::size_t s = 0; s < spaces.size(); ++s) {
    for (std::size_t b = 0; b < spaces.size(); ++b) {
      if (s >= 2 && b >= 2) continue;  // left to the runtime
      const Seen at = Locate(spaces[s], spaces[b], now);
      ASSERT_EQ(at.result, XR_SUCCESS);
      ASSERT_EQ(at.location.locationFlags, kSeen);
      ASSERT_EQ(at.velocity.velocityFlags, layer::kVelocityValid);
      const Seen before = Locate(spaces[s], spaces[b], now - kStep_ns);
      const Seen after = Locate(spaces[s], spaces[b], now + kStep_ns);
      const glm::dvec3 v = (after.p() - before.p()) / kTwoSteps_s;
      const glm::dvec3 w = TurnRate(before.q(), after.q());
      // Single precision in the poses: 1e-6 m in 4 ms.
      EXPECT_LT(glm::length(at.v() - v), 1e-3 * glm::length(v) + 5e-4) << "space " << s << " in " << b;
      EXPECT_LT(glm::length(at.w() - w), 2e-3 * glm::length(w) + 1e-3) << "space " << s << " in " << b;
      if (s < 2 && b < 2) {
        EXPECT_EQ(glm::length(at.v()) + glm::length(at.w()), 0) << "one rigid body";
      } else {
        EXPECT_GT(glm::length(v), 0.01) << "enough motion to be a test";
      }
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, SpacesLever, testing::Range(1, 7));

// A runtime that knows no velocities: what is at rest in the anchor has a zero one all the same; the head's is unknown.
TEST_F(SpacesTest, VelocityInViewIsInvalidIfRuntimeReportsNone) {
  App app;
  Start(app);
  const XrSpace view = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  const XrSpace stage = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_STAGE);
  ASSERT_EQ(omni_test_report_velocities(0), 0);
  service.Fill();
  const std::int64_t t = Now_ns() - 20'000'000;
  EXPECT_EQ(Locate(pen, local, t).velocity.velocityFlags, layer::kVelocityValid);
  EXPECT_EQ(Locate(pen, stage, t).velocity.velocityFlags, layer::kVelocityValid);
  EXPECT_EQ(Locate(stage, pen, t).velocity.velocityFlags, layer::kVelocityValid);
  EXPECT_EQ(Locate(pen, view, t).velocity.velocityFlags, 0u);
  EXPECT_EQ(Locate(view, pen, t).velocity.velocityFlags, 0u);
  EXPECT_EQ(glm::length(Locate(pen, view, t).v()), 0);
}

}  // namespace test_spaces_lever
}  // namespace omni::test
