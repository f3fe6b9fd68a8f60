// XR_OMNIX1_force_feedback as an application sees it, with a scripted service.
#include <cmath>
#include <limits>
#include <memory>

#include "tests/layer/force/fixture.h"

namespace omni::test {
namespace test_force {

using protocol::ForceStanding;

constexpr float kNaN = std::numeric_limits<float>::quiet_NaN();
constexpr XrDuration kFrame_ns = kForceFrame_ns;

class Force : public ForceTest {};

TEST_F(Force, FunctionsNeedTheExtension) {
  App without;
  PFN_xrVoidFunction found = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(without.instance, "xrApplyForceOMNIX1", &found), XR_ERROR_FUNCTION_UNSUPPORTED);
}

TEST_F(Force, SystemPropertiesFollowTheService) {
  Start();
  const XrSystemForceFeedbackPropertiesOMNIX1 there = SystemSays();
  EXPECT_FLOAT_EQ(there.maxForce, 2);
  EXPECT_FLOAT_EQ(there.updateRate, 1000);
  EXPECT_EQ(there.maxConstraintCount, 8U);
  EXPECT_NE(there.capabilityFlags & XR_FORCE_FEEDBACK_CAPABILITY_FORCE_3DOF_BIT_OMNIX1, 0U);
  service_.SetForce(false, ForceStanding::kFree);
  ASSERT_TRUE(app_->SyncUntil(service_, [&] { return SystemSays().supportsForceFeedback == XR_FALSE; }));
  EXPECT_EQ(SystemSays().maxForce, 0);
  XrForceFeedbackOMNIX1 force = XR_NULL_HANDLE;
  EXPECT_EQ(Create(force), XR_ERROR_FEATURE_UNSUPPORTED);
}

TEST_F(Force, CreateChecksHandPathAndOwner) {
  Start();
  XrForceFeedbackOMNIX1 other = XR_NULL_HANDLE;
  EXPECT_EQ(Create(other, "/user/hand/left"), XR_ERROR_PATH_UNSUPPORTED);
  const XrForceFeedbackCreateInfoOMNIX1 no_path{XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1, nullptr, XR_NULL_PATH};
  EXPECT_EQ(xr_->create(app_->session, &no_path, &other), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(xr_->create(app_->session, nullptr, &other), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(xr_->create(XR_NULL_HANDLE, &no_path, &other), XR_ERROR_HANDLE_INVALID);
  ASSERT_EQ(Create(force_), XR_SUCCESS);
  EXPECT_EQ(Create(other), XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1);
  const auto claim = Heard<protocol::ForceClaim>(1);
  ASSERT_TRUE(claim);
  EXPECT_EQ(claim->wanted, 1U);
  ASSERT_EQ(xr_->destroy(force_), XR_SUCCESS);
  EXPECT_EQ(xr_->destroy(force_), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Heard<protocol::ForceClaim>(2)->wanted, 0U);
  service_.SetForce(true, ForceStanding::kTaken);
  EXPECT_TRUE(app_->SyncUntil(service_, [&] {
    const XrResult result = Create(other);
    if (XR_SUCCEEDED(result)) xr_->destroy(other);
    return result == XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1;
  }));
}

// LOCAL -> base while it is not aligned: x stays, y (up) becomes z, z (towards the user) becomes -y.
TEST_F(Force, ForceIsTransformedToBaseFrame) {
  StartWithHandle();
  ASSERT_EQ(Push({0.1f, 0.2f, 0.3f}, local_, kFrame_ns, 5'000'000), XR_SUCCESS);
  const auto heard = Heard<protocol::ForceApply>(1);
  ASSERT_TRUE(heard);
  EXPECT_NEAR(heard->force_base_N[0], 0.1, 1e-6);
  EXPECT_NEAR(heard->force_base_N[1], -0.3, 1e-6);
  EXPECT_NEAR(heard->force_base_N[2], 0.2, 1e-6);
  EXPECT_EQ(heard->duration_ns, kFrame_ns);
  EXPECT_EQ(heard->ramp_ns, 5'000'000);
  EXPECT_NEAR(static_cast<double>(heard->t_ns), static_cast<double>(Now_ns()), 5e9);
  // A space turned by 90 degrees about LOCAL's y: its x is LOCAL's -z.
  const float h = std::sqrt(0.5f);
  const XrSpace turned = app_->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, h, 0, h}, {1, 2, 3}});
  ASSERT_EQ(Push({0.5f, 0, 0}, turned), XR_SUCCESS);
  const auto second = Heard<protocol::ForceApply>(2);
  EXPECT_NEAR(second->force_base_N[1], 0.5, 1e-6);
}

TEST_F(Force, OversizedForceAndDurationAreClampedNotRejected) {
  StartWithHandle();
  ASSERT_EQ(Push({3e30f, 0, 4e30f}, local_, 5'000'000'000, 5'000'000'000), XR_SUCCESS);
  const auto heard = Heard<protocol::ForceApply>(1);
  ASSERT_TRUE(heard);
  EXPECT_EQ(heard->duration_ns, XR_MAX_FORCE_DURATION_OMNIX1);
  EXPECT_EQ(heard->ramp_ns, XR_MAX_FORCE_DURATION_OMNIX1);
  EXPECT_NEAR(heard->force_base_N[0] / std::hypot(heard->force_base_N[0], heard->force_base_N[1]), 0.6, 1e-5);
}

TEST_F(Force, InvalidArgumentsAreRejectedAndSendNothing) {
  StartWithHandle();
  EXPECT_EQ(Push({kNaN, 0, 0}, local_), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Push({0, std::numeric_limits<float>::infinity(), 0}, local_), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Push({1, 0, 0}, local_, 0), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Push({1, 0, 0}, local_, -1), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Push({1, 0, 0}, local_, kFrame_ns, -1), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Push({1, 0, 0}, XR_NULL_HANDLE), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(xr_->apply(force_, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(xr_->apply(XR_NULL_HANDLE, nullptr), XR_ERROR_HANDLE_INVALID);
  auto point = Point(local_);
  point.stiffness = -1;
  EXPECT_EQ(Set({&point}), XR_ERROR_VALIDATION_FAILURE);
  point = Point(local_);
  point.maxForce = kNaN;
  EXPECT_EQ(Set({&point}), XR_ERROR_VALIDATION_FAILURE);
  point = Point(local_, {0, kNaN, 0});
  EXPECT_EQ(Set({&point}), XR_ERROR_VALIDATION_FAILURE);
  point = Point(XR_NULL_HANDLE);
  EXPECT_EQ(Set({&point}), XR_ERROR_HANDLE_INVALID);
  point = Point(local_);
  point.type = XR_TYPE_FORCE_APPLY_INFO_OMNIX1;
  EXPECT_EQ(Set({&point}), XR_ERROR_VALIDATION_FAILURE);
  XrForceFeedbackConstraintPlaneOMNIX1 plane{
      XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_PLANE_OMNIX1, nullptr, local_, 200, 0, 1, {0, 0, 0}, {0, 0, 0}};
  EXPECT_EQ(Set({&plane}), XR_ERROR_VALIDATION_FAILURE) << "no normal";
  XrForceFeedbackConstraintSphereOMNIX1 sphere{
      XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_SPHERE_OMNIX1, nullptr, local_, 200, 0, 1, {0, 0, 0}, 0};
  EXPECT_EQ(Set({&sphere}), XR_ERROR_VALIDATION_FAILURE) << "no radius";
  XrForceFeedbackConstraintViscousOMNIX1 viscous{
      XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_VISCOUS_OMNIX1, nullptr, local_, 1, 1, 1};
  EXPECT_EQ(Set({&viscous}), XR_ERROR_VALIDATION_FAILURE) << "a stiffness";
  const auto good = Point(local_);
  EXPECT_EQ(Set({&good, &good, &good, &good, &good, &good, &good, &good, &good}), XR_ERROR_LIMIT_REACHED);
  EXPECT_EQ(Set({&good, nullptr}), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(app_->Sync(), XR_SUCCESS);
  EXPECT_EQ(Count<protocol::ForceApply>() + Count<protocol::ForceConstraints>(), 0U);
}

TEST_F(Force, ConstraintsAreTransformedToBaseFrame) {
  StartWithHandle();
  const auto point = Point(local_, {0.1f, -0.35f, -0.40f});
  const XrForceFeedbackConstraintPlaneOMNIX1 plane{
      XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_PLANE_OMNIX1, nullptr, local_, 500, 1, 2, {7, -0.30f, 9}, {0, 3, 0},
      XR_FORCE_FEEDBACK_SIDE_OUTSIDE_OMNIX1};
  ASSERT_EQ(Set({&point, &plane}), XR_SUCCESS);
  const auto heard = Heard<protocol::ForceConstraints>(1);
  ASSERT_TRUE(heard);
  ASSERT_EQ(heard->count, 2U);
  const protocol::ForceConstraint& p = heard->constraints[0];
  EXPECT_EQ(p.shape, protocol::ForceShape::kPoint);
  EXPECT_NEAR(p.point_base_m[0], 0.1, 1e-6);
  EXPECT_NEAR(p.point_base_m[1], -0.05, 1e-6) << "the base stands 0.45 m in front";
  EXPECT_NEAR(p.point_base_m[2], 0, 1e-6) << "and 0.35 m below";
  EXPECT_FLOAT_EQ(static_cast<float>(p.stiffness_N_m), 200);
  const protocol::ForceConstraint& q = heard->constraints[1];
  EXPECT_EQ(q.side, protocol::ForceSide::kOutside);
  EXPECT_NEAR(q.direction_base[2], 1, 1e-6);
  EXPECT_NEAR(q.point_base_m[2], 0.05, 1e-6);
  EXPECT_NEAR(q.point_base_m[0], 0, 1e-6) << "the point of the plane nearest to the base";
}

// Constraints at rest are sent once, moving ones at every sync, with their velocity.
TEST_F(Force, ConstraintsFollowTheirSpace) {
  StartWithHandle();
  const float pose[7] = {0, 1.6f, -0.5f, 0, 0, 0, 1};
  ASSERT_EQ(omni_test_set_head(pose, nullptr), 0);
  const XrSpace view = app_->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  const auto point = Point(view);
  const auto still = Point(local_);
  ASSERT_EQ(Set({&still}), XR_SUCCESS);
  ASSERT_TRUE(Heard<protocol::ForceConstraints>(1));
  for (int i = 0; i < 5; ++i) ASSERT_EQ(app_->Sync(), XR_SUCCESS);
  EXPECT_EQ(Count<protocol::ForceConstraints>(), 1U);
  ASSERT_EQ(Set({&point}), XR_SUCCESS);
  const float velocity[6] = {0.5f, 0, 0, 0, 0, 0};
  ASSERT_EQ(omni_test_set_head(pose, velocity), 0);
  const std::size_t before = Count<protocol::ForceConstraints>();
  const auto moving = Heard<protocol::ForceConstraints>(before + 3);
  ASSERT_TRUE(moving);
  EXPECT_NEAR(moving->constraints[0].velocity_base_m_s[0], 0.5, 1e-4);
  // A destroyed space removes its constraints.
  ASSERT_EQ(xrDestroySpace(view), XR_SUCCESS);
  ASSERT_TRUE(app_->SyncUntil(service_, [&] {
    const auto all = service_.heard().forces;
    const auto* last = std::get_if<protocol::ForceConstraints>(&all.back());
    return last && last->count == 0;
  }));
}

TEST_F(Force, UnlocatableSpaceIsAnError) {
  StartWithHandle();
  const XrSpace nowhere = app_->ActionSpace(app_->pose, app_->left);
  omni_test_set_device("left", 0, nullptr);
  ASSERT_EQ(app_->Sync(), XR_SUCCESS);
  EXPECT_EQ(Push({1, 0, 0}, nowhere), XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1);
  const auto point = Point(nowhere);
  EXPECT_EQ(Set({&point}), XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1);
  EXPECT_EQ(Count<protocol::ForceApply>() + Count<protocol::ForceConstraints>(), 0U);
}

// In the pen's own space: along its axis.
TEST_F(Force, ForceInPenSpaceActsAlongThePen) {
  service_.SetTrajectory([](protocol::ToolSample& sample) {
    sample.position_base_m = {0, 0, 0.06};
    sample.orientation_base_wxyz = {0, 1, 0, 0};  // half a turn about x: -z of the pen is +z of the base
  });
  StartWithHandle();
  const XrSpace pen = app_->ActionSpace(app_->pose, app_->right);
  ASSERT_TRUE(app_->SyncUntil(service_, [&] { return Push({0, 0, -0.4f}, pen) == XR_SUCCESS; }));
  const auto heard = Heard<protocol::ForceApply>(1);
  EXPECT_NEAR(heard->force_base_N[2], 0.4, 1e-6);
}

TEST_F(Force, LosingFocusEndsForcesAndConstraints) {
  StartWithHandle();
  const auto point = Point(local_);
  ASSERT_EQ(Set({&point}), XR_SUCCESS);
  ASSERT_EQ(Push({1, 0, 0}, local_), XR_SUCCESS);
  ASSERT_TRUE(Heard<protocol::ForceApply>(1));
  omni_test_set_focus(0);
  ASSERT_EQ(app_->Sync(), XR_SESSION_NOT_FOCUSED);
  EXPECT_EQ(Push({1, 0, 0}, local_), XR_SESSION_NOT_FOCUSED);
  EXPECT_EQ(Set({&point}), XR_SESSION_NOT_FOCUSED);
  EXPECT_FALSE(State().isActive);
  EXPECT_NE(State().stateFlags & XR_FORCE_FEEDBACK_STATE_FOCUS_LOST_BIT_OMNIX1, 0U);
  const std::int64_t end = Now_ns() + 5'000'000'000;
  const auto reported = [&] {
    return Count<protocol::ForceStop>() > 0 && service_.heard().last_session() == protocol::SessionState::kBegun;
  };
  while (!reported() && Now_ns() < end) app_->Poll();
  EXPECT_EQ(Count<protocol::ForceStop>(), 1U);
  EXPECT_EQ(service_.heard().last_session(), protocol::SessionState::kBegun);
  omni_test_set_focus(1);
  app_->Poll();
  const std::size_t before = Count<protocol::ForceConstraints>();
  for (int i = 0; i < 5; ++i) ASSERT_EQ(app_->Sync(), XR_SUCCESS);
  EXPECT_EQ(Count<protocol::ForceConstraints>(), before) << "what was set before is gone";
}

TEST_F(Force, StopEndsForceAndConstraints) {
  StartWithHandle();
  const auto point = Point(local_);
  ASSERT_EQ(Set({&point}), XR_SUCCESS);
  ASSERT_EQ(xr_->stop(force_), XR_SUCCESS);
  ASSERT_TRUE(Heard<protocol::ForceStop>(1));
  EXPECT_EQ(xr_->stop(force_), XR_SUCCESS) << "also if there is nothing to stop";
}

TEST_F(Force, DestroyingSessionInvalidatesHandles) {
  StartWithHandle();
  ASSERT_EQ(xrDestroySession(app_->session), XR_SUCCESS);
  EXPECT_EQ(xr_->stop(force_), XR_ERROR_HANDLE_INVALID);
}

TEST_F(Force, StateReportsNewestSampleInRequestedSpace) {
  service_.SetTrajectory([](protocol::ToolSample& sample) {
    sample.position_base_m = {0, 0, 0.06};
    sample.force_base_N = {0.1, 0.2, 0.3};
    sample.contact_count = 2;
    sample.flags |= protocol::kToolForceCut;
  });
  StartWithHandle();
  ASSERT_TRUE(app_->SyncUntil(service_, [&] { return State().isActive == XR_TRUE; }));
  service_.Fill();
  const XrForceFeedbackStateOMNIX1 state = State();
  EXPECT_TRUE(state.isForceValid);
  EXPECT_NEAR(state.appliedForce.x, 0.1, 1e-6);
  EXPECT_NEAR(state.appliedForce.y, 0.3, 1e-6) << "up";
  EXPECT_NEAR(state.appliedForce.z, -0.2, 1e-6);
  EXPECT_EQ(state.contactCount, 2U);
  EXPECT_EQ(state.stateFlags, XR_FORCE_FEEDBACK_STATE_SATURATED_BIT_OMNIX1);
  XrForceFeedbackStateGetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1, nullptr, local_, 0};
  XrForceFeedbackStateOMNIX1 out{XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1};
  EXPECT_EQ(xr_->state(force_, &info, &out), XR_ERROR_TIME_INVALID);
}

TEST_F(Force, PropertiesReportWorkspaceAndReach) {
  StartWithHandle();
  const XrForceFeedbackPropertiesGetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_PROPERTIES_GET_INFO_OMNIX1, nullptr, local_,
                                                    Now_ns() + kRuntimeOffset_ns};
  XrForceFeedbackPropertiesOMNIX1 out{XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1};
  ASSERT_EQ(xr_->properties(force_, &info, &out), XR_SUCCESS);
  EXPECT_EQ(out.reachCountOutput, 2U);
  EXPECT_NEAR(out.workspacePose.position.y, -0.35, 1e-6);
  EXPECT_NEAR(out.workspacePose.position.z, -0.45, 1e-6);
  EXPECT_NEAR(std::abs(out.workspacePose.orientation.w), 1, 1e-6) << "+y up, -z away from the user, as LOCAL";
  EXPECT_FLOAT_EQ(out.innerRadius, 0.04f);
  XrForceFeedbackReachOMNIX1 reach[2];
  out.reach = reach;
  out.reachCapacityInput = 1;
  EXPECT_EQ(xr_->properties(force_, &info, &out), XR_ERROR_SIZE_INSUFFICIENT);
  out.reachCapacityInput = 2;
  ASSERT_EQ(xr_->properties(force_, &info, &out), XR_SUCCESS);
  EXPECT_FLOAT_EQ(reach[0].force, 1.5f);
  EXPECT_FLOAT_EQ(reach[1].distance, 0.15f);
}

TEST_F(Force, StateChangedEventWhenDeviceIsTaken) {
  StartWithHandle();
  ASSERT_TRUE(app_->SyncUntil(service_, [&] {
    app_->Poll();
    return app_->CountEvents(XR_TYPE_EVENT_DATA_FORCE_FEEDBACK_STATE_CHANGED_OMNIX1) >= 1 || State().isActive;
  }));
  const int before = app_->CountEvents(XR_TYPE_EVENT_DATA_FORCE_FEEDBACK_STATE_CHANGED_OMNIX1);
  service_.SetForce(true, ForceStanding::kTaken);
  ASSERT_TRUE(app_->SyncUntil(service_, [&] {
    app_->Poll();
    return app_->CountEvents(XR_TYPE_EVENT_DATA_FORCE_FEEDBACK_STATE_CHANGED_OMNIX1) > before;
  }));
  EXPECT_NE(State().stateFlags & XR_FORCE_FEEDBACK_STATE_IN_USE_BIT_OMNIX1, 0U);
  EXPECT_EQ(Push({1, 0, 0}, local_), XR_ERROR_FORCE_FEEDBACK_IN_USE_OMNIX1);
}

TEST_F(Force, NothingIsSentWithoutAHandle) {
  Start();
  for (int i = 0; i < 10; ++i) ASSERT_EQ(app_->Sync(), XR_SUCCESS);
  EXPECT_TRUE(service_.heard().forces.empty());
}

// A restarted service receives the claim and the constraints again.
TEST(ForceReconnect, ClaimAndConstraintsAreResentAfterReconnect) {
  omni_test_reset();
  auto service = std::make_unique<FakeService>();
  service->SetForce(true, ForceStanding::kYours);
  App app(WithForce());
  const ForceFunctions xr(app.instance);
  const XrSpace local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  const XrForceFeedbackCreateInfoOMNIX1 create{XR_TYPE_FORCE_FEEDBACK_CREATE_INFO_OMNIX1, nullptr, app.right};
  XrForceFeedbackOMNIX1 force = XR_NULL_HANDLE;
  ASSERT_TRUE(app.SyncUntil(*service, [&] { return xr.create(app.session, &create, &force) == XR_SUCCESS; }));
  const XrForceFeedbackConstraintPointOMNIX1 point{
      XR_TYPE_FORCE_FEEDBACK_CONSTRAINT_POINT_OMNIX1, nullptr, local, 200, 0, 1, {0, 0, 0}};
  const auto* header = reinterpret_cast<const XrForceFeedbackConstraintBaseHeaderOMNIX1*>(&point);
  const XrForceFeedbackConstraintsSetInfoOMNIX1 set{XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1, nullptr, 1,
                                                    &header};
  ASSERT_EQ(xr.constraints(force, &set), XR_SUCCESS);
  service.reset();
  service = std::make_unique<FakeService>();
  EXPECT_TRUE(app.SyncUntil(*service, [&] {
    bool claimed = false;
    bool constrained = false;
    for (const protocol::ForceRequest& request : service->heard().forces) {
      claimed = claimed || std::holds_alternative<protocol::ForceClaim>(request);
      constrained = constrained || std::holds_alternative<protocol::ForceConstraints>(request);
    }
    return claimed && constrained;
  }));
}

}  // namespace test_force
}  // namespace omni::test
