// Action states from the pen, the runtime and both together, and when they change.
#include <gtest/gtest.h>
#include <time.h>

#include "tests/layer/actions/states_fixture.h"

namespace omni::test {
namespace test_states {

using protocol::InputIndex;

using States = StatesTest;

TEST_F(States, PensClickDrivesBooleanTriggerAction) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  EXPECT_TRUE(app.Bool(app.select, app.right).isActive);
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState);
  service.Set(InputIndex::kSelect, 1);
  service.Set(InputIndex::kTipForce, 0.2f);
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState) << "nothing changes between syncs";
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState) << "the service's click stands for the trigger";
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.2f) << "parent path: trigger -> trigger/value";
}

// A press that came and went between two syncs is one pressed sync.
TEST_F(States, PressBetweenSyncsIsOnePressedSync) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  service.Set(InputIndex::kSelect, 0);
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
  EXPECT_TRUE(app.Bool(app.select, app.right).changedSinceLastSync);
  Step(app, service);
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState);
  EXPECT_TRUE(app.Bool(app.select, app.right).changedSinceLastSync);
  Step(app, service);
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState);
  EXPECT_FALSE(app.Bool(app.select, app.right).changedSinceLastSync);
}

// Released and pressed again between two syncs: both presses are seen.
TEST_F(States, ReleaseBetweenSyncsIsOneReleasedSync) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  Step(app, service);
  service.Set(InputIndex::kSelect, 0);
  service.Set(InputIndex::kSelect, 1);
  Step(app, service);
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState);
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
}

// [XrActionStateBoolean] changedSinceLastSync, and lastChangeTime as the physical time in the runtime's clock.
TEST_F(States, ChangeReportsPhysicalTimeOfThePress) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const XrTime before = Now_ns() + kRuntimeOffset_ns;
  service.Set(InputIndex::kSelect, 1);
  const XrTime after = Now_ns() + kRuntimeOffset_ns;
  const timespec pause{0, 10'000'000};
  nanosleep(&pause, nullptr);
  Step(app, service);
  const XrActionStateBoolean pressed = app.Bool(app.select, app.right);
  EXPECT_TRUE(pressed.changedSinceLastSync);
  EXPECT_GE(pressed.lastChangeTime, before);
  EXPECT_LE(pressed.lastChangeTime, after) << "the time of the press, not of the sync";
  Step(app, service);
  const XrActionStateBoolean held = app.Bool(app.select, app.right);
  EXPECT_FALSE(held.changedSinceLastSync);
  EXPECT_EQ(held.lastChangeTime, pressed.lastChangeTime);
}

// [input-suggested-bindings] boolean from an analog source: threshold with hysteresis.
TEST_F(States, AnalogThresholdHasHysteresis) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const std::pair<float, bool> steps[] = {{0.45f, false}, {0.55f, true}, {0.45f, true}, {0.35f, false}, {0.45f, false}};
  for (const auto& [value, pressed] : steps) {
    service.Set(InputIndex::kSqueeze, value);
    Step(app, service);
    EXPECT_EQ(app.Bool(app.squeeze, app.right).currentState == XR_TRUE, pressed) << value;
  }
}

// [input-suggested-bindings] vector from the parent path of x and y.
TEST_F(States, ThumbstickParentPathYieldsVector) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kThumbstickX, -0.6f);
  service.Set(InputIndex::kThumbstickY, 0.8f);
  Step(app, service);
  const XrActionStateVector2f stick = app.Vector(app.stick, app.right);
  EXPECT_TRUE(stick.isActive);
  EXPECT_FLOAT_EQ(stick.currentState.x, -0.6f);
  EXPECT_FLOAT_EQ(stick.currentState.y, 0.8f);
}

// [input-multiple] XR_NULL_PATH: boolean or, largest magnitude, longest vector over the pen and the other hand.
TEST_F(States, NullPathMergesPenAndRuntime) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  omni_test_set_float("/user/hand/left/input/trigger/value", 0.9f);
  omni_test_set_vector2("/user/hand/left/input/thumbstick", 0.1f, 0.1f);
  service.Set(InputIndex::kTipForce, 0.3f);
  service.Set(InputIndex::kThumbstickX, -0.9f);
  Step(app, service);
  EXPECT_FLOAT_EQ(app.Float(app.force, XR_NULL_PATH).currentState, 0.9f);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.3f);
  EXPECT_FLOAT_EQ(app.Vector(app.stick, XR_NULL_PATH).currentState.x, -0.9f);
  EXPECT_TRUE(app.Bool(app.select, XR_NULL_PATH).currentState) << "the left trigger is pressed";
  omni_test_set_float("/user/hand/left/input/trigger/value", 0.0f);
  service.Set(InputIndex::kSelect, 1);
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.select, XR_NULL_PATH).currentState) << "now the pen is";
  EXPECT_FALSE(app.Bool(app.select, XR_NULL_PATH).changedSinceLastSync) << "true stays true";
  EXPECT_FLOAT_EQ(app.Float(app.force, XR_NULL_PATH).currentState, 0.3f);
  EXPECT_TRUE(app.Float(app.force, XR_NULL_PATH).changedSinceLastSync);
}

// The hand is the pen's: a runtime's controller in the same hand is ignored while the pen is present.
TEST_F(States, PenSuppressesRuntimeControllerOfSameHand) {
  omni_test_set_device("right", 1, kTouch);
  App app;
  omni_test_set_float("/user/hand/right/input/trigger/value", 1.0f);
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 1.0f) << "no pen yet";
  FakeService service;
  ASSERT_TRUE(app.SyncUntil(service, [&] { return app.Float(app.force, app.right).currentState == 0.0f; }));
  EXPECT_FLOAT_EQ(app.Float(app.force, XR_NULL_PATH).currentState, 0.0f);
}

TEST_F(States, ActionsWithoutSubactionPathsReceivePenInput) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSecondary, 1);
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.plain, XR_NULL_PATH).isActive);
  EXPECT_TRUE(app.Bool(app.plain, XR_NULL_PATH).currentState);
}

TEST_F(States, UnsuggestedActionIsInactive) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  EXPECT_FALSE(app.Bool(app.unbound, app.right).isActive);
  EXPECT_FALSE(app.Bool(app.unbound, XR_NULL_PATH).isActive);
}

// [input-creating-actions] subaction rules hold with the pen as without.
TEST_F(States, WrongSubactionPathOrTypeIsRejected) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  XrActionStateBoolean state{XR_TYPE_ACTION_STATE_BOOLEAN};
  XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, app.select, app.Path("/user/gamepad")};
  EXPECT_EQ(xrGetActionStateBoolean(app.session, &info, &state), XR_ERROR_PATH_UNSUPPORTED);
  info.subactionPath = 987654321;
  EXPECT_EQ(xrGetActionStateBoolean(app.session, &info, &state), XR_ERROR_PATH_INVALID);
  info = {XR_TYPE_ACTION_STATE_GET_INFO, nullptr, app.plain, app.right};
  EXPECT_EQ(xrGetActionStateBoolean(app.session, &info, &state), XR_ERROR_PATH_UNSUPPORTED);
  info = {XR_TYPE_ACTION_STATE_GET_INFO, nullptr, app.force, app.right};
  EXPECT_EQ(xrGetActionStateBoolean(app.session, &info, &state), XR_ERROR_ACTION_TYPE_MISMATCH);
  EXPECT_EQ(xrGetActionStateBoolean(app.session, nullptr, &state), XR_ERROR_VALIDATION_FAILURE);
}

// [input-state-sync] not focused: the success code XR_SESSION_NOT_FOCUSED, everything inactive and zero.
TEST_F(States, StatesAreInactiveWithoutFocus) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  Step(app, service);
  ASSERT_TRUE(app.Bool(app.select, app.right).currentState);
  omni_test_set_focus(0);
  service.Fill();
  EXPECT_EQ(app.Sync(), XR_SESSION_NOT_FOCUSED);
  const XrActionStateBoolean state = app.Bool(app.select, app.right);
  EXPECT_FALSE(state.isActive);
  EXPECT_FALSE(state.currentState);
  EXPECT_FALSE(state.changedSinceLastSync);
  EXPECT_EQ(state.lastChangeTime, 0);
  EXPECT_FALSE(app.PoseActive(app.pose, app.right));
  omni_test_set_focus(1);
  app.Poll();
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
  EXPECT_FALSE(app.Bool(app.select, app.right).changedSinceLastSync) << "it was not active in the sync before";
}

// [XrActionSetCreateInfo] a source feeds only the active set of the highest priority that binds it.
TEST_F(States, HigherPrioritySetTakesTheSource) {
  FakeService service;
  AppOptions options;
  options.attach = false;
  App app(options);
  const XrActionSet high = app.MakeSet("high", 5);
  const XrAction grab = app.MakeAction(high, "grab", XR_ACTION_TYPE_BOOLEAN_INPUT);
  ASSERT_EQ(app.Suggest(kTouch, {{app.select, "/user/hand/right/input/trigger/value"},
                                 {app.squeeze, "/user/hand/right/input/squeeze/value"},
                                 {grab, "/user/hand/right/input/trigger/touch"}}),
            XR_SUCCESS);
  const XrActionSet both[] = {app.set, high};
  const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 2, both};
  ASSERT_EQ(xrAttachSessionActionSets(app.session, &attach), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
  EXPECT_FALSE(app.Bool(grab, app.right).isActive) << "its set is not active";
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, XR_NULL_PATH}, {high, XR_NULL_PATH}}), XR_SUCCESS);
  EXPECT_TRUE(app.Bool(grab, app.right).currentState);
  EXPECT_FALSE(app.Bool(app.select, app.right).isActive) << "the trigger is taken";
  EXPECT_TRUE(app.Bool(app.squeeze, app.right).isActive) << "the squeeze is not";
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, XR_NULL_PATH}, {high, app.left}}), XR_SUCCESS);
  EXPECT_TRUE(app.Bool(app.select, app.right).isActive) << "the high set is active for the left hand only";
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, app.left}}), XR_SUCCESS);
  EXPECT_FALSE(app.Bool(app.select, app.right).isActive) << "so is this one now";
}

// A destroyed pen: inactive at the next sync, and back without a restart of the application.
TEST_F(States, PenReturnsAfterServiceRestart) {
  App app;
  for (int life = 0; life < 2; ++life) {
    FakeService service;
    ASSERT_TRUE(app.WaitProfile(service, kTouch)) << "life " << life;
    EXPECT_TRUE(app.PoseActive(app.pose, app.right));
    service.Set(InputIndex::kSelect, 1);
    Step(app, service);
    EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
    service.SetFlags(0);  // the last samples say: no pose
    service.Fill();
    EXPECT_TRUE(app.PoseActive(app.pose, app.right)) << "state holds until the next sync";
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    EXPECT_FALSE(app.PoseActive(app.pose, app.right));
    EXPECT_FALSE(app.Bool(app.select, app.right).isActive);
    EXPECT_EQ(app.Profile(app.right), "");
  }
}

// Two processors for many programs: the service may lose its own while it writes. Found by scripts/engines: then the
// hand was the controller's for one sync. The samples are stamped ahead, so that a slow test does not look like a
// silent service.
TEST_F(States, ServiceInterruptedWhileItWritesKeepsThePen) {
  omni_test_set_device("right", 1, kTouch);
  omni_test_set_float("/user/hand/right/input/trigger/value", 0.75f);
  FakeService service;
  service.SetTrajectory([](protocol::ToolSample& sample) { sample.t_ns += 60'000'000'000; });
  App app;
  service.Set(InputIndex::kTipForce, 0.25f);
  ASSERT_TRUE(app.SyncUntil(service, [&] { return app.Float(app.force, app.right).currentState == 0.25f; }));
  service.StopWhileWriting(true);
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.25f);
  service.StopWhileWriting(false);
  Step(app, service);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.25f);
}

TEST_F(States, ServiceThatStopsWhileItWritesHasNoPen) {
  omni_test_set_device("right", 1, kTouch);
  omni_test_set_float("/user/hand/right/input/trigger/value", 0.75f);
  FakeService service;
  App app;
  service.Set(InputIndex::kTipForce, 0.25f);
  ASSERT_TRUE(app.SyncUntil(service, [&] { return app.Float(app.force, app.right).currentState == 0.25f; }));
  service.StopWhileWriting(true);
  const timespec longer{.tv_sec = 0, .tv_nsec = 150'000'000};
  nanosleep(&longer, nullptr);
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.75f);
}

// Presses made before the pen belonged to this session are not reported.
TEST_F(States, PressesBeforeThePenArrivesAreIgnored) {
  FakeService service;
  service.Set(InputIndex::kSelect, 1);
  service.Set(InputIndex::kSelect, 0);
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState);
}

}  // namespace test_states
}  // namespace omni::test
