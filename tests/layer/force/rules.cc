// Rules of docs/extensions/XR_OMNIX1_force_feedback.md about other sessions, past times, sizes and how forces end.
#include <algorithm>
#include <cmath>
#include <limits>

#include "layer/src/service/service_link.h"
#include "tests/layer/force/fixture.h"

namespace omni::test {
namespace test_force_rules {

using protocol::ForceConstraints;
using protocol::ForceStop;

class ForceRules : public ForceTest {
 protected:
  // Syncs until the service's newest constraints are that many.
  bool HoldsConstraints(std::uint32_t count) {
    return app_->SyncUntil(service_, [&] {
      const auto all = service_.heard().forces;
      const auto last = std::find_if(all.rbegin(), all.rend(),
                                     [](const auto& r) { return std::holds_alternative<ForceConstraints>(r); });
      return last != all.rend() && std::get<ForceConstraints>(*last).count == count;
    });
  }
  XrResult StateAt(XrSpace base, XrTime time, XrForceFeedbackStateOMNIX1& state) {
    const XrForceFeedbackStateGetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1, nullptr, base, time};
    state = {XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1};
    return xr_->state(force_, &info, &state);
  }
  XrResult PropertiesAt(XrSpace base, XrTime time, XrForceFeedbackPropertiesOMNIX1& out) {
    const XrForceFeedbackPropertiesGetInfoOMNIX1 info{XR_TYPE_FORCE_FEEDBACK_PROPERTIES_GET_INFO_OMNIX1, nullptr, base,
                                                      time};
    return xr_->properties(force_, &info, &out);
  }
};

// [System support] the service answers within milliseconds, but seldom before an application's first query.
TEST_F(ForceRules, FirstQueryWaitsForTheService) {
  constexpr std::int64_t kPatience_ns =
      layer::ServiceLink::kDevicePatience_ns;  // a service on a busy machine may take it all
  int supported = 0, impatient = 0;
  for (int i = 0; i < 20; ++i) {
    service_.SetForce(true, protocol::ForceStanding::kFree);
    app_.emplace(WithForceAndNoMore());
    const std::int64_t begin_ns = Now_ns();
    const bool said = SystemSays().supportsForceFeedback == XR_TRUE;
    supported += said;
    impatient += !said && Now_ns() - begin_ns < kPatience_ns;
  }
  EXPECT_EQ(impatient, 0) << "of 20";
  EXPECT_GT(supported, 0);
}

// [New Object Types] a handle belongs to its session: spaces of another one are rejected as by xrLocateSpace.
TEST_F(ForceRules, SpacesOfAnotherSessionAreRefused) {
  StartWithHandle();
  const XrSession first = app_->session;
  const XrSessionCreateInfo create{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, app_->system};
  ASSERT_EQ(xrCreateSession(app_->instance, &create, &app_->session), XR_SUCCESS);
  ASSERT_EQ(app_->Attach(), XR_SUCCESS);
  app_->state = XR_SESSION_STATE_UNKNOWN;
  app_->PollUntilFocused();
  ASSERT_TRUE(app_->WaitProfile(service_, kTouch));
  const XrSpace theirs = app_->ActionSpace(app_->pose, app_->right);
  ASSERT_EQ(app_->Sync(), XR_SUCCESS);
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
  const XrTime now = Now_ns() + kRuntimeOffset_ns;
  const XrResult refused = xrLocateSpace(theirs, local_, now, &location);
  ASSERT_TRUE(XR_FAILED(refused));
  EXPECT_EQ(Push({1, 0, 0}, theirs), refused);
  const auto point = Point(theirs);
  EXPECT_EQ(Set({&point}), refused);
  XrForceFeedbackStateOMNIX1 state;
  EXPECT_EQ(StateAt(theirs, now, state), refused);
  XrForceFeedbackPropertiesOMNIX1 properties{XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1};
  EXPECT_EQ(PropertiesAt(theirs, now, properties), refused);
  EXPECT_EQ(Count<protocol::ForceApply>() + Count<ForceConstraints>(), 0U);
  EXPECT_EQ(xrDestroySession(app_->session), XR_SUCCESS);
  app_->session = first;
}

// [xrSetForceFeedbackConstraintsOMNIX1] "While a space cannot be located, its constraints do not act."
TEST_F(ForceRules, ConstraintsOfUnlocatableSpaceAreSuspended) {
  StartWithHandle();
  const XrSpace left = app_->ActionSpace(app_->pose, app_->left);
  ASSERT_EQ(app_->Sync(), XR_SUCCESS);
  const auto in_left = Point(left);
  const auto in_local = Point(local_);
  ASSERT_EQ(Set({&in_left, &in_local}), XR_SUCCESS);
  ASSERT_TRUE(HoldsConstraints(2));
  omni_test_set_tracking("left", 0, 0);
  EXPECT_TRUE(HoldsConstraints(1)) << "the other one goes on";
  omni_test_set_tracking("left", 1, 1);
  EXPECT_TRUE(HoldsConstraints(2));
}

// [xrStopForceFeedbackOMNIX1] stopped constraints are not sent again, though their space moves.
TEST_F(ForceRules, StoppedConstraintsAreNotResent) {
  StartWithHandle();
  const float pose[7] = {0, 1.6f, -0.5f, 0, 0, 0, 1};
  const float velocity[6] = {0.5f, 0, 0, 0, 0, 0};
  ASSERT_EQ(omni_test_set_head(pose, velocity), 0);
  const auto point = Point(app_->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW));
  ASSERT_EQ(Set({&point}), XR_SUCCESS);
  ASSERT_TRUE(Heard<ForceConstraints>(3)) << "it moves: sent at every sync";
  ASSERT_EQ(xr_->stop(force_), XR_SUCCESS);
  ASSERT_TRUE(Heard<ForceStop>(1));
  const auto after_stop = [&] {
    const auto all = service_.heard().forces;
    const auto stop =
        std::find_if(all.begin(), all.end(), [](const auto& r) { return std::holds_alternative<ForceStop>(r); });
    return std::count_if(stop, all.end(), [](const auto& r) { return std::holds_alternative<ForceConstraints>(r); });
  };
  for (int i = 0; i < 10; ++i) ASSERT_EQ(app_->Sync(), XR_SUCCESS);
  ASSERT_EQ(xr_->stop(force_), XR_SUCCESS) << "also if there is nothing to stop";
  ASSERT_TRUE(Heard<ForceStop>(2)) << "everything sent before it has arrived, too";
  EXPECT_EQ(after_stop(), 0);
}

// [xrGetForceFeedbackStateOMNIX1] "the newest sample that is not newer than getInfo->time", 250 ms of them; flags and
// isActive are current for a past time too.
TEST_F(ForceRules, StateAtPastTimeReportsSampleOfThatTime) {
  service_.SetTrajectory([](protocol::ToolSample& sample) {
    sample.position_base_m = {0, 0, 0.06};
    sample.force_base_N = {0, 0, 1e-9 * static_cast<double>(sample.t_ns % 1'000'000'000)};
  });
  const std::int64_t begin_ns = Now_ns();
  StartWithHandle();
  ASSERT_TRUE(app_->SyncUntil(service_, [&] { return Now_ns() - begin_ns > 220'000'000 && State().isActive; }));
  service_.Fill();
  const XrTime now = Now_ns() + kRuntimeOffset_ns;
  for (const XrDuration ago : {5'000'000, 60'000'000, 200'000'000}) {
    XrForceFeedbackStateOMNIX1 state;
    ASSERT_EQ(StateAt(local_, now - ago, state), XR_SUCCESS);
    EXPECT_LE(state.sampleTime, now - ago);
    EXPECT_GT(state.sampleTime, now - ago - 3'000'000) << "one sample per millisecond";
    const double t_s = 1e-9 * static_cast<double>((state.sampleTime - kRuntimeOffset_ns) % 1'000'000'000);
    EXPECT_NEAR(static_cast<double>(state.appliedForce.y), t_s, 2e-5) << "the force of that sample";
    EXPECT_EQ(state.stateFlags & XR_FORCE_FEEDBACK_STATE_STALE_BIT_OMNIX1, 0U);
    EXPECT_EQ(state.isActive, XR_TRUE);
  }
  XrForceFeedbackStateOMNIX1 ahead;
  ASSERT_EQ(StateAt(local_, now + 1'000'000'000, ahead), XR_SUCCESS);
  EXPECT_GT(ahead.sampleTime, now - 100'000'000) << "the newest";
}

// [xrGetForceFeedbackPropertiesOMNIX1] the two-call idiom: too small a capacity writes the count alone.
TEST_F(ForceRules, PropertiesValidateTimeSizeAndSpace) {
  StartWithHandle();
  const XrTime now = Now_ns() + kRuntimeOffset_ns;
  XrForceFeedbackReachOMNIX1 reach[2] = {{-1, -1}, {-1, -1}};
  XrForceFeedbackPropertiesOMNIX1 out{XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1};
  out.reach = reach;
  out.reachCapacityInput = 1;
  out.innerRadius = 7;
  out.workspacePose.position.x = 7;
  EXPECT_EQ(PropertiesAt(local_, now, out), XR_ERROR_SIZE_INSUFFICIENT);
  EXPECT_EQ(out.reachCountOutput, 2U);
  EXPECT_EQ(out.innerRadius, 7) << "a call that fails changes nothing";
  EXPECT_EQ(out.workspacePose.position.x, 7);
  EXPECT_EQ(reach[0].distance, -1);
  out.reach = nullptr;
  EXPECT_EQ(PropertiesAt(local_, now, out), XR_ERROR_VALIDATION_FAILURE) << "a capacity without an array";
  out.reachCapacityInput = 0;
  EXPECT_EQ(PropertiesAt(local_, now, out), XR_SUCCESS);
  const XrSpace pen = app_->ActionSpace(app_->pose, app_->right);
  XrForceFeedbackStateOMNIX1 state;
  for (const XrTime time : {XrTime{0}, XrTime{-1}, std::numeric_limits<XrTime>::min()}) {
    for (const XrSpace space : {local_, pen}) {
      EXPECT_EQ(PropertiesAt(space, time, out), XR_ERROR_TIME_INVALID);
      EXPECT_EQ(StateAt(space, time, state), XR_ERROR_TIME_INVALID);
    }
  }
  EXPECT_EQ(PropertiesAt(XR_NULL_HANDLE, now, out), XR_ERROR_HANDLE_INVALID);
  service_.SetForce(false, protocol::ForceStanding::kFree);
  ASSERT_TRUE(app_->SyncUntil(service_, [&] { return SystemSays().supportsForceFeedback == XR_FALSE; }));
  EXPECT_EQ(PropertiesAt(local_, now, out), XR_ERROR_FEATURE_UNSUPPORTED) << "the device has gone";
}

// Structures of a wrong type and null pointers: VALIDATION_FAILURE from every function.
TEST_F(ForceRules, InvalidStructuresAreRejected) {
  StartWithHandle();
  XrForceFeedbackStateGetInfoOMNIX1 ask{XR_TYPE_FORCE_FEEDBACK_STATE_GET_INFO_OMNIX1, nullptr, local_, 1};
  XrForceFeedbackStateOMNIX1 state{XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1};
  EXPECT_EQ(xr_->state(force_, nullptr, &state), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(xr_->state(force_, &ask, nullptr), XR_ERROR_VALIDATION_FAILURE);
  state.type = XR_TYPE_FORCE_APPLY_INFO_OMNIX1;
  EXPECT_EQ(xr_->state(force_, &ask, &state), XR_ERROR_VALIDATION_FAILURE);
  state.type = XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1;
  ask.baseSpace = XR_NULL_HANDLE;
  EXPECT_EQ(xr_->state(force_, &ask, &state), XR_ERROR_HANDLE_INVALID);
  XrForceApplyInfoOMNIX1 push{XR_TYPE_FORCE_APPLY_INFO_OMNIX1, nullptr, local_, {1, 0, 0}, kForceFrame_ns, 0};
  push.type = XR_TYPE_FORCE_FEEDBACK_STATE_OMNIX1;
  EXPECT_EQ(xr_->apply(force_, &push), XR_ERROR_VALIDATION_FAILURE);
  XrForceFeedbackConstraintsSetInfoOMNIX1 set{XR_TYPE_FORCE_FEEDBACK_CONSTRAINTS_SET_INFO_OMNIX1, nullptr, 1, nullptr};
  EXPECT_EQ(xr_->constraints(force_, &set), XR_ERROR_VALIDATION_FAILURE) << "a count without a list";
  set.constraintCount = 0;
  EXPECT_EQ(xr_->constraints(force_, &set), XR_SUCCESS) << "removes all constraints";
  set.type = XR_TYPE_FORCE_APPLY_INFO_OMNIX1;
  EXPECT_EQ(xr_->constraints(force_, &set), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(xr_->constraints(force_, nullptr), XR_ERROR_VALIDATION_FAILURE);
}

// [xrDestroyForceFeedbackOMNIX1] a destroyed handle is invalid for every function, and its events are not delivered.
TEST_F(ForceRules, DestroyedHandleIsInvalidAndHasNoEvents) {
  StartWithHandle();
  ASSERT_TRUE(app_->SyncUntil(service_, [&] { return State().isActive == XR_TRUE; }));
  app_->Poll();
  app_->events.clear();
  service_.SetForce(true, protocol::ForceStanding::kTaken);
  ASSERT_TRUE(
      app_->SyncUntil(service_, [&] { return (State().stateFlags & XR_FORCE_FEEDBACK_STATE_IN_USE_BIT_OMNIX1) != 0; }));
  ASSERT_EQ(app_->Sync(), XR_SUCCESS) << "notices it: an event is queued";
  ASSERT_EQ(xr_->destroy(force_), XR_SUCCESS);
  app_->Poll();
  EXPECT_EQ(app_->CountEvents(XR_TYPE_EVENT_DATA_FORCE_FEEDBACK_STATE_CHANGED_OMNIX1), 0);
  EXPECT_EQ(Push({1, 0, 0}, local_), XR_ERROR_HANDLE_INVALID);
  const auto point = Point(local_);
  EXPECT_EQ(Set({&point}), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(xr_->stop(force_), XR_ERROR_HANDLE_INVALID);
  XrForceFeedbackStateOMNIX1 state;
  EXPECT_EQ(StateAt(local_, Now_ns() + kRuntimeOffset_ns, state), XR_ERROR_HANDLE_INVALID);
  XrForceFeedbackPropertiesOMNIX1 properties{XR_TYPE_FORCE_FEEDBACK_PROPERTIES_OMNIX1};
  EXPECT_EQ(PropertiesAt(local_, Now_ns() + kRuntimeOffset_ns, properties), XR_ERROR_HANDLE_INVALID);
}

// [When forces end] the service receives a stop, and the release of the device, when the session ends.
TEST_F(ForceRules, SessionEndStopsForcesAndReleasesDevice) {
  StartWithHandle();
  ASSERT_EQ(Push({1, 0, 0}, local_), XR_SUCCESS);
  ASSERT_EQ(xrDestroySession(app_->session), XR_SUCCESS);
  EXPECT_TRUE(Eventually([&] {
    const auto all = service_.heard().forces;
    const auto* claim = all.empty() ? nullptr : std::get_if<protocol::ForceClaim>(&all.back());
    return Count<ForceStop>() >= 1 && claim && claim->wanted == 0;
  }));
}

// [Valid usage] an invalid space or time is an error also where the base's pose is unknown.
TEST_F(ForceRules, ArgumentsAreCheckedWithoutKnownBasePose) {
  protocol::BasePose unknown;
  unknown.uncalibrated = protocol::Uncalibrated::kCalibrated;
  service_.SetBasePose(unknown);
  StartWithHandle();
  const XrSpace gone = app_->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  ASSERT_EQ(xrDestroySpace(gone), XR_SUCCESS);
  EXPECT_EQ(Push({1, 0, 0}, gone), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(Push({1, 0, 0}, local_), XR_ERROR_FORCE_FEEDBACK_SPACE_NOT_LOCATABLE_OMNIX1);
  XrForceFeedbackStateOMNIX1 state;
  ASSERT_EQ(StateAt(local_, Now_ns() + kRuntimeOffset_ns, state), XR_SUCCESS);
  EXPECT_EQ(state.isForceValid, XR_FALSE);
}

}  // namespace test_force_rules
}  // namespace omni::test
