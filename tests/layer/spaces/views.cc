// Views and a tracked hand, located in a space of the pen.
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "tests/layer/spaces/fixture.h"

namespace omni::test {
namespace test_spaces_views {

using layer::Motion;

class SpacesViews : public SpacesTest {
 protected:
  void SetUp() override {
    SpacesTest::SetUp();
    AppOptions options;
    options.extensions = {XR_EXT_HAND_TRACKING_EXTENSION_NAME};
    app = std::make_unique<App>(options);
    Start(*app);
    service.Fill();
    now = Now_ns() - 20'000'000;
  }

  struct Eyes {
    XrResult result = XR_SUCCESS;
    XrViewState state{XR_TYPE_VIEW_STATE};
    std::array<XrView, 2> views{XrView{XR_TYPE_VIEW}, XrView{XR_TYPE_VIEW}};
    std::uint32_t count = 0;
  };
  Eyes LocateEyes(XrSpace space, XrTime time) const {
    Eyes out;
    const XrViewLocateInfo info{XR_TYPE_VIEW_LOCATE_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, time,
                                space};
    out.result = xrLocateViews(app->session, &info, &out.state, 2, &out.count, out.views.data());
    return out;
  }

  std::unique_ptr<App> app;
  std::int64_t now = 0;
};

// [xrLocateViews] in the pen's space: the eyes, as LOCAL knows them, seen from the pen.
TEST_F(SpacesViews, ViewsAreLocatedInPenSpace) {
  const Eyes in_local = LocateEyes(local, ToXrTime(now));
  const Eyes in_pen = LocateEyes(pen, ToXrTime(now));
  ASSERT_EQ(in_pen.result, XR_SUCCESS);
  ASSERT_EQ(in_pen.count, 2u);
  EXPECT_EQ(in_pen.state.viewStateFlags, kSeen);
  const Motion tip = InLocal(Lissajous(1e-9 * static_cast<double>(now)));
  for (std::size_t eye = 0; eye < 2; ++eye) {
    const layer::Pose truth = layer::Compose(layer::Inverse(tip.X), layer::FromXr(in_local.views[eye].pose));
    const layer::Pose seen = layer::FromXr(in_pen.views[eye].pose);
    EXPECT_LT(glm::length(seen.p - truth.p), 1e-5);
    EXPECT_LT(Angle(seen.q, truth.q), 1e-3);
    EXPECT_EQ(in_pen.views[eye].fov.angleLeft, in_local.views[eye].fov.angleLeft);
  }
}

TEST_F(SpacesViews, LocateViewsMakesOneRuntimeCall) {
  const long views = omni_test_call_count("xrLocateViews");
  const long spaces = omni_test_call_count("xrLocateSpace");
  ASSERT_EQ(LocateEyes(pen, ToXrTime(now)).result, XR_SUCCESS);
  EXPECT_EQ(omni_test_call_count("xrLocateViews"), views + 1);
  EXPECT_EQ(omni_test_call_count("xrLocateSpace"), spaces);
}

// The errors and the sizes are the runtime's.
TEST_F(SpacesViews, LocateViewsRejectsInvalidSizesAndArguments) {
  Eyes eyes;
  XrViewLocateInfo info{XR_TYPE_VIEW_LOCATE_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, ToXrTime(now),
                        pen};
  EXPECT_EQ(xrLocateViews(app->session, &info, &eyes.state, 0, &eyes.count, nullptr), XR_SUCCESS);
  EXPECT_EQ(eyes.count, 2u);
  EXPECT_EQ(xrLocateViews(app->session, &info, &eyes.state, 1, &eyes.count, eyes.views.data()),
            XR_ERROR_SIZE_INSUFFICIENT);
  EXPECT_EQ(xrLocateViews(app->session, nullptr, &eyes.state, 2, &eyes.count, eyes.views.data()),
            XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(xrLocateViews(app->session, &info, nullptr, 2, &eyes.count, eyes.views.data()),
            XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(LocateEyes(pen, 0).result, XR_ERROR_TIME_INVALID);
  EXPECT_EQ(LocateEyes(XR_NULL_HANDLE, ToXrTime(now)).result, XR_ERROR_HANDLE_INVALID);
}

// Bits follow the pen's: lost, gone, not active.
TEST_F(SpacesViews, ViewFlagsFollowPenTracking) {
  service.SetFlags(protocol::kToolPoseValid);
  service.Fill();
  EXPECT_EQ(LocateEyes(pen, ToXrTime(Now_ns())).state.viewStateFlags, layer::kValid);
  service.SetFlags(0);
  service.Fill();
  const Eyes gone = LocateEyes(pen, ToXrTime(Now_ns()));
  EXPECT_EQ(gone.state.viewStateFlags, 0u);
  EXPECT_EQ(gone.views[0].pose.orientation.w, 1.0f) << "a pose, if not a valid one";
  service.SetFlags(protocol::kToolPoseValid | protocol::kToolTracked);
  service.Fill();
  ASSERT_EQ(app->SyncSets({{app->set, app->left}}), XR_SUCCESS);
  EXPECT_EQ(LocateEyes(pen, ToXrTime(Now_ns())).state.viewStateFlags, 0u);
}

class SpacesHands : public SpacesViews {
 protected:
  void SetUp() override {
    SpacesViews::SetUp();
    const float palm[7] = {0.1f, 1.2f, -0.3f, 0, 0, 0, 1};
    const float moving[6] = {0.2f, -0.1f, 0.1f, 0.3f, 1, -0.5f};
    ASSERT_EQ(omni_test_set_hand("left", 1, palm, moving), 0);
    const XrHandTrackerCreateInfoEXT create{XR_TYPE_HAND_TRACKER_CREATE_INFO_EXT, nullptr, XR_HAND_LEFT_EXT,
                                            XR_HAND_JOINT_SET_DEFAULT_EXT};
    ASSERT_EQ(Function<PFN_xrCreateHandTrackerEXT>("xrCreateHandTrackerEXT")(app->session, &create, &tracker),
              XR_SUCCESS);
    locate_ = Function<PFN_xrLocateHandJointsEXT>("xrLocateHandJointsEXT");
  }

  template <class Pointer>
  Pointer Function(const char* name) const {
    const auto found = FunctionOf<Pointer>(app->instance, name);
    EXPECT_NE(found, nullptr) << name;
    return found;
  }

  struct Joints {
    XrResult result = XR_SUCCESS;
    std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT> location{};
    std::array<XrHandJointVelocityEXT, XR_HAND_JOINT_COUNT_EXT> velocity{};
  };
  Joints LocateHand(XrSpace base, XrTime time, std::uint32_t count = XR_HAND_JOINT_COUNT_EXT) const {
    Joints out;
    const XrHandJointsLocateInfoEXT info{XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, nullptr, base, time};
    XrHandJointVelocitiesEXT rates{XR_TYPE_HAND_JOINT_VELOCITIES_EXT, nullptr, count, out.velocity.data()};
    XrHandJointLocationsEXT places{XR_TYPE_HAND_JOINT_LOCATIONS_EXT, &rates, XR_FALSE, count, out.location.data()};
    out.result = locate_(tracker, &info, &places);
    return out;
  }

  XrHandTrackerEXT tracker = XR_NULL_HANDLE;
  PFN_xrLocateHandJointsEXT locate_ = nullptr;
};

// [XR_EXT_hand_tracking] joints in the pen, with velocities that agree with central differences of the poses.
TEST_F(SpacesHands, HandJointsAreLocatedInPenSpace) {
  const Joints at = LocateHand(pen, ToXrTime(now));
  const Joints in_local = LocateHand(local, ToXrTime(now));
  ASSERT_EQ(at.result, XR_SUCCESS);
  constexpr std::int64_t kStep_ns = 2'000'000;
  const Joints before = LocateHand(pen, ToXrTime(now - kStep_ns));
  const Joints after = LocateHand(pen, ToXrTime(now + kStep_ns));
  const Motion tip = InLocal(Lissajous(1e-9 * static_cast<double>(now)));
  for (std::size_t i = 0; i < at.location.size(); ++i) {
    ASSERT_EQ(at.location[i].locationFlags, kSeen);
    const layer::Pose truth = layer::Compose(layer::Inverse(tip.X), layer::FromXr(in_local.location[i].pose));
    EXPECT_LT(glm::length(layer::FromXr(at.location[i].pose).p - truth.p), 1e-5);
    EXPECT_GT(at.location[i].radius, 0);
    ASSERT_EQ(at.velocity[i].velocityFlags, layer::kVelocityValid);
    const glm::dvec3 difference = (layer::FromXr(after.location[i].pose).p - layer::FromXr(before.location[i].pose).p) /
                                  (2e-9 * static_cast<double>(kStep_ns));
    const glm::dvec3 v = layer::FromXr(at.velocity[i].linearVelocity);
    EXPECT_LT(glm::length(v - difference), 0.01 * glm::length(difference)) << i;
  }
}

// [XR_FB_hand_tracking_aim, _capsules] poses in the same answer. This runtime fills none: the test fills them as if it
// had, in the anchor (LOCAL).
TEST_F(SpacesHands, AimAndCapsulesAreTransformedWithTheJoints) {
  const auto ask = [&](XrHandTrackingAimStateFB& aim, XrHandTrackingCapsulesStateFB& capsules) {
    std::array<XrHandJointLocationEXT, XR_HAND_JOINT_COUNT_EXT> joints{};
    aim.next = &capsules;
    XrHandJointLocationsEXT places{XR_TYPE_HAND_JOINT_LOCATIONS_EXT, &aim, XR_FALSE, XR_HAND_JOINT_COUNT_EXT,
                                   joints.data()};
    const XrHandJointsLocateInfoEXT info{XR_TYPE_HAND_JOINTS_LOCATE_INFO_EXT, nullptr, pen, ToXrTime(now)};
    ASSERT_EQ(locate_(tracker, &info, &places), XR_SUCCESS);
  };
  XrHandTrackingAimStateFB aim{XR_TYPE_HAND_TRACKING_AIM_STATE_FB};
  XrHandTrackingCapsulesStateFB capsules{XR_TYPE_HAND_TRACKING_CAPSULES_STATE_FB};
  aim.status = XR_HAND_TRACKING_AIM_COMPUTED_BIT_FB | XR_HAND_TRACKING_AIM_VALID_BIT_FB;
  aim.aimPose = {{0, 0, 0, 1}, {0.3f, -0.2f, -0.5f}};
  capsules.capsules[7].points[1] = {0.1f, 0.2f, -0.3f};
  ask(aim, capsules);
  const layer::Pose X_SL = layer::Inverse(InLocal(Lissajous(1e-9 * static_cast<double>(now))).X);
  EXPECT_LT(
      glm::length(layer::FromXr(aim.aimPose.position) - layer::Compose(X_SL, {{0.3, -0.2, -0.5}, {1, 0, 0, 0}}).p),
      1e-5);
  EXPECT_LT(glm::length(layer::FromXr(capsules.capsules[7].points[1]) -
                        layer::Compose(X_SL, {{0.1, 0.2, -0.3}, {1, 0, 0, 0}}).p),
            1e-5);
  ASSERT_EQ(app->SyncSets({{app->set, app->left}}), XR_SUCCESS);
  ask(aim, capsules);
  EXPECT_EQ(aim.status, XrHandTrackingAimFlagsFB{XR_HAND_TRACKING_AIM_COMPUTED_BIT_FB}) << "the base cannot be located";
}

TEST_F(SpacesHands, InvalidArgumentsFailAndUnlocatableBaseClearsFlags) {
  EXPECT_EQ(LocateHand(pen, 0).result, XR_ERROR_TIME_INVALID);
  EXPECT_EQ(LocateHand(pen, ToXrTime(now), 3).result, XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(LocateHand(XR_NULL_HANDLE, ToXrTime(now)).result, XR_ERROR_HANDLE_INVALID);
  service.SetFlags(0);
  service.Fill();
  const Joints gone = LocateHand(pen, ToXrTime(Now_ns()));
  ASSERT_EQ(gone.result, XR_SUCCESS);
  EXPECT_EQ(gone.location[5].locationFlags, 0u);
  EXPECT_EQ(gone.velocity[5].velocityFlags, 0u);
  ASSERT_EQ(Function<PFN_xrDestroyHandTrackerEXT>("xrDestroyHandTrackerEXT")(tracker), XR_SUCCESS);
  EXPECT_EQ(LocateHand(pen, ToXrTime(now)).result, XR_ERROR_HANDLE_INVALID);
}

}  // namespace test_spaces_views
}  // namespace omni::test
