// A pen that is put down yields its hand to the runtime's controller, and takes it back when it is picked up.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "layer/src/actions/pen.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_states_put_down {

using protocol::InputIndex;

constexpr std::int64_t kSyncPeriod_ns = 11'111'111;

layer::PenSnapshot PenAt(std::int64_t t_ns, double x_m) {
  layer::PenSnapshot pen;
  pen.present = true;
  pen.sample.t_ns = t_ns;
  pen.sample.flags = protocol::kToolPoseValid | protocol::kToolTracked;
  pen.sample.position_base_m = {x_m, 0, 0.06};
  return pen;
}

// Without a session: one pen that is held, put down, or lost.
class RestingPen {
 public:
  explicit RestingPen(std::uint64_t seed = 1) : noise_(seed) {}
  layer::PenSnapshot pen = PenAt(0, 0);
  layer::RestLimits limits;

  // Time passes with the pen at its place, `sigma_m` of noise on each axis. True: put down at the end.
  bool Wait(double seconds, double sigma_m = 0) {
    bool down = false;
    const std::int64_t end_ns = pen.sample.t_ns + static_cast<std::int64_t>(1e9 * seconds);
    std::normal_distribution<double> normal;
    while (pen.sample.t_ns < end_ns) {
      pen.sample.t_ns += kSyncPeriod_ns;
      layer::PenSnapshot seen = pen;
      for (double& x : seen.sample.position_base_m) x += sigma_m * normal(noise_);
      down = rest_.Update(seen, limits);
    }
    return down;
  }

 private:
  std::mt19937_64 noise_;
  layer::PenRest rest_;
};

TEST(PenRest, StillPenCountsAsPutDownUntilMoved) {
  RestingPen p;
  EXPECT_FALSE(p.Wait(19.5));
  EXPECT_TRUE(p.Wait(1));
  p.pen.sample.position_base_m[0] += 0.005;
  EXPECT_TRUE(p.Wait(0.5)) << "the table was bumped";
  p.pen.sample.position_base_m[2] += 0.02;
  EXPECT_FALSE(p.Wait(0.1)) << "picked up";
  EXPECT_FALSE(p.Wait(19));
}

// The tracker's noise is not motion: a lying pen is put down for any seed.
TEST(PenRest, TrackerNoiseIsNotMotion) {
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    RestingPen p(seed);
    EXPECT_TRUE(p.Wait(25, 0.0003)) << seed;
    EXPECT_TRUE(p.Wait(30, 0.0003)) << seed << ": and stays so";
  }
}

// A pen in use is never put down: slow motion, contact, or input in time.
TEST(PenRest, HeldPenIsNeverPutDown) {
  RestingPen p;
  for (int i = 0; i < 20; ++i) {
    p.pen.sample.position_base_m[1] = 0.004 * (i % 2);
    ASSERT_FALSE(p.Wait(10)) << i;
  }
  p.pen.sample.flags |= protocol::kToolContact;
  EXPECT_FALSE(p.Wait(60)) << "leant on a surface";
  p.pen.sample.flags &= ~static_cast<std::uint32_t>(protocol::kToolContact);
  for (int i = 0; i < 5; ++i) {
    p.pen.inputs.components[1].t_change_ns = p.pen.sample.t_ns;
    ASSERT_FALSE(p.Wait(15)) << "a key was pressed";
  }
  EXPECT_TRUE(p.Wait(10));
}

TEST(PenRest, RotationCountsAsMotion) {
  RestingPen p;
  for (int i = 0; i < 4; ++i) {
    const double half_rad = 0.05 * (i + 1);
    p.pen.sample.orientation_base_wxyz = {std::cos(half_rad), std::sin(half_rad), 0, 0};
    ASSERT_FALSE(p.Wait(15)) << i;
  }
}

TEST(PenRest, DockedOrUntrackedPenCountsAsPutDown) {
  RestingPen p;
  p.pen.inputs.components[static_cast<std::size_t>(InputIndex::kDocked)].value = 1;
  EXPECT_TRUE(p.Wait(0.02)) << "docked: at once";
  p.pen.inputs.components[static_cast<std::size_t>(InputIndex::kDocked)].value = 0;
  EXPECT_FALSE(p.Wait(0.02));
  p.pen.sample.flags = protocol::kToolPoseValid;
  EXPECT_FALSE(p.Wait(0.9));
  EXPECT_TRUE(p.Wait(0.2)) << "not seen for a second";
  p.pen.sample.flags |= protocol::kToolTracked;
  EXPECT_FALSE(p.Wait(0.02));
  p.limits.still_ns = 0;
  EXPECT_FALSE(p.Wait(120)) << "never, with a limit of 0";
}

class StatesPutDown : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
};

struct Seen {
  std::string profile;
  float force = 0;
  bool pose = false;
  bool pen_located = false;
  std::string source;
};

class Desk {  // a pen and the runtime's controller of the same hand
 public:
  Desk() {
    app.Poll();
    local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    hand = app.ActionSpace(app.pose, app.right);
  }
  float Force() const { return app.Float(app.force, app.right).currentState; }
  // x of the hand's space: the pen's default place is in the middle, the runtime's controller at 0.2 m.
  float X() const {
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
    EXPECT_EQ(xrLocateSpace(hand, local, Now_ns() + kRuntimeOffset_ns, &location), XR_SUCCESS);
    EXPECT_TRUE(location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT);
    return location.pose.position.x;
  }
  App app;
  XrSpace local = XR_NULL_HANDLE;
  XrSpace hand = XR_NULL_HANDLE;
};

// States, spaces and the rest follow in one sync, and back.
TEST_F(StatesPutDown, DockedPenYieldsHandToRuntimeController) {
  omni_test_set_device("right", 1, kTouch);
  omni_test_set_float("/user/hand/right/input/trigger/value", 0.75f);
  FakeService service;
  Desk desk;
  service.Set(InputIndex::kTipForce, 0.25f);
  ASSERT_TRUE(desk.app.SyncUntil(service, [&] { return desk.Force() == 0.25f; }));
  EXPECT_NEAR(desk.X(), 0.0f, 1e-4f);
  for (int i = 0; i < 3; ++i) {
    service.Set(InputIndex::kDocked, 1);
    service.Fill();
    EXPECT_FLOAT_EQ(desk.Force(), 0.25f) << "not before the sync";
    ASSERT_EQ(desk.app.Sync(), XR_SUCCESS);
    EXPECT_FLOAT_EQ(desk.Force(), 0.75f);
    EXPECT_TRUE(desk.app.Float(desk.app.force, desk.app.right).changedSinceLastSync);
    EXPECT_NEAR(desk.X(), 0.2f, 1e-4f);
    EXPECT_TRUE(desk.app.PoseActive(desk.app.pose, XR_NULL_PATH));
    service.Set(InputIndex::kDocked, 0);
    service.Fill();
    ASSERT_EQ(desk.app.Sync(), XR_SUCCESS);
    EXPECT_FLOAT_EQ(desk.Force(), 0.25f);
    EXPECT_NEAR(desk.X(), 0.0f, 1e-4f);
  }
}

// If the runtime has no controller for that hand, the pen keeps it.
TEST_F(StatesPutDown, DockedPenKeepsHandWithoutRuntimeController) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kDocked, 1);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(app.Profile(app.right), kTouch);
  EXPECT_TRUE(app.PoseActive(app.pose, app.right));
}

// After the time that the service has set; with an event, since the profile changes.
TEST_F(StatesPutDown, StillPenYieldsHandAfterServiceTimeout) {
  omni_test_set_device("right", 1, kSimple);
  FakeService service;
  protocol::AppSettings settings;
  settings.rest_after_s = 0.2f;
  service.Wish(settings);
  AppOptions options;
  options.profiles = {kTouch, kSimple};
  App app(options);
  double x_m = 0;
  service.SetTrajectory([&x_m](protocol::ToolSample& sample) { sample.position_base_m = {x_m, 0, 0.06}; });
  ASSERT_TRUE(app.SyncUntil(service, [&] {
    x_m = x_m > 0 ? 0 : 0.02;  // held
    return app.Profile(app.right) == kTouch;
  }));
  app.Poll();
  app.events.clear();
  ASSERT_TRUE(app.WaitProfile(service, kSimple)) << "left alone";
  app.Poll();
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 1);
  x_m = 0.05;
  EXPECT_TRUE(app.WaitProfile(service, kTouch)) << "picked up";
}

}  // namespace test_states_put_down
}  // namespace omni::test
