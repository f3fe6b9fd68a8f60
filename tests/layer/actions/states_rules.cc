// Rules of action states that need two devices, two sets, or a special moment.
#include <gtest/gtest.h>

#include "tests/layer/actions/states_fixture.h"

namespace omni::test {
namespace test_states_rules {

using protocol::InputIndex;

class StatesRules : public StatesTest {
 protected:
  static AppOptions Unattached(std::vector<const char*> extensions = {}) {
    AppOptions options;
    options.attach = false;
    options.extensions = std::move(extensions);
    return options;
  }
};

const XrBaseInStructure* Chain(const void* structure) { return static_cast<const XrBaseInStructure*>(structure); }

XrResult SuggestWith(const App& app, const char* profile, XrAction action, const char* path, const void* next) {
  const XrActionSuggestedBinding binding{action, app.Path(path)};
  const XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, Chain(next),
                                                  app.Path(profile), 1, &binding};
  return xrSuggestInteractionProfileBindings(app.instance, &info);
}

XrInteractionProfileAnalogThresholdVALVE Threshold(const App& app, XrAction action, const char* path, float on,
                                                   float off) {
  return {
      XR_TYPE_INTERACTION_PROFILE_ANALOG_THRESHOLD_VALVE, nullptr, action, app.Path(path), on, off, nullptr, nullptr};
}

// [XrActionSetCreateInfo] sets of equal priority are both fed.
TEST_F(StatesRules, EqualPrioritySetsShareTheSource) {
  FakeService service;
  App app(Unattached());
  const TwoSets sets(app, 0);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, XR_NULL_PATH}, {sets.second, XR_NULL_PATH}}), XR_SUCCESS);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
  EXPECT_TRUE(app.Bool(sets.grab, app.right).currentState);
}

// [XrActionSetCreateInfo] a set that is active for the other hand only takes none of the pen's sources, although its
// action is bound there.
TEST_F(StatesRules, SourceReturnsWhenHigherPrioritySetIsInactive) {
  FakeService service;
  App app(Unattached());
  const XrActionSet high = app.MakeSet("high", 7);
  const XrAction grab = app.MakeAction(high, "grab", XR_ACTION_TYPE_FLOAT_INPUT);
  ASSERT_EQ(app.Suggest(kTouch, {{app.select, "/user/hand/right/input/trigger/touch"},
                                 {app.select, "/user/hand/right/input/a/click"},
                                 {grab, "/user/hand/right/input/trigger/value"}}),
            XR_SUCCESS);
  ASSERT_EQ(AttachSets(app, {app.set, high}), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, XR_NULL_PATH}, {high, XR_NULL_PATH}}), XR_SUCCESS);
  EXPECT_TRUE(app.Bool(app.select, app.right).isActive) << "its other source is free";
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState) << "the trigger is taken";
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, XR_NULL_PATH}, {high, app.left}}), XR_SUCCESS);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
  EXPECT_FALSE(app.Float(grab, app.right).isActive);
}

// XR_EXT_active_action_set_priority: for this one sync.
TEST_F(StatesRules, PriorityOverrideHoldsForOneSync) {
  FakeService service;
  App app(Unattached({XR_EXT_ACTIVE_ACTION_SET_PRIORITY_EXTENSION_NAME}));
  const XrActionSet low = app.MakeSet("low", 0);
  const XrActionSet high = app.MakeSet("high", 5);
  const XrAction a = app.MakeAction(low, "a", XR_ACTION_TYPE_BOOLEAN_INPUT);
  const XrAction b = app.MakeAction(high, "b", XR_ACTION_TYPE_BOOLEAN_INPUT);
  ASSERT_EQ(app.Suggest(kTouch, {{a, "/user/hand/right/input/a/click"},
                                 {a, "/user/hand/left/input/x/click"},
                                 {b, "/user/hand/right/input/a/click"},
                                 {b, "/user/hand/left/input/x/click"}}),
            XR_SUCCESS);
  ASSERT_EQ(AttachSets(app, {app.set, low, high}), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const XrActiveActionSet active[] = {{low, XR_NULL_PATH}, {high, XR_NULL_PATH}};
  XrActiveActionSetPriorityEXT priority{low, 9};
  const XrActiveActionSetPrioritiesEXT priorities{XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT, nullptr, 1, &priority};
  for (const bool overridden : {true, false}) {
    const XrActionsSyncInfo info{XR_TYPE_ACTIONS_SYNC_INFO, overridden ? Chain(&priorities) : nullptr, 2, active};
    service.Fill();
    ASSERT_EQ(xrSyncActions(app.session, &info), XR_SUCCESS);
    for (const XrPath hand : {app.left, app.right}) {
      EXPECT_EQ(app.Bool(a, hand).isActive == XR_TRUE, overridden) << app.Text(hand);
      EXPECT_EQ(app.Bool(b, hand).isActive == XR_TRUE, !overridden) << app.Text(hand);
    }
  }
}

// XR_VALVE_analog_threshold, chained or in XrBindingModificationsKHR, instead of the layer's own threshold.
TEST_F(StatesRules, ApplicationsThresholdIsUsed) {
  constexpr const char* kPath = "/user/hand/right/input/squeeze/value";
  for (const bool in_array : {false, true}) {
    FakeService service;
    App app(Unattached({XR_KHR_BINDING_MODIFICATION_EXTENSION_NAME, XR_VALVE_ANALOG_THRESHOLD_EXTENSION_NAME}));
    const auto threshold = Threshold(app, app.squeeze, kPath, 0.9f, 0.2f);
    const XrBindingModificationBaseHeaderKHR* const all[] = {
        static_cast<const XrBindingModificationBaseHeaderKHR*>(static_cast<const void*>(&threshold))};
    const XrBindingModificationsKHR modifications{XR_TYPE_BINDING_MODIFICATIONS_KHR, nullptr, 1, all};
    const void* next = in_array ? static_cast<const void*>(&modifications) : &threshold;
    ASSERT_EQ(SuggestWith(app, kTouch, app.squeeze, kPath, next), XR_SUCCESS);
    ASSERT_EQ(app.Attach(), XR_SUCCESS);
    ASSERT_TRUE(app.WaitProfile(service, kTouch));
    const std::pair<float, bool> steps[] = {{0.8f, false}, {0.95f, true}, {0.3f, true}, {0.1f, false}, {0.7f, false}};
    for (const auto& [value, pressed] : steps) {
      service.Set(InputIndex::kSqueeze, value);
      Step(app, service);
      EXPECT_EQ(app.Bool(app.squeeze, app.right).currentState == XR_TRUE, pressed) << value << " " << in_array;
    }
  }
}

// ... on the tip's force its thresholds override the service's click; its pulses are sent at the edges.
TEST_F(StatesRules, TipThresholdOverridesClickAndSendsPulse) {
  constexpr const char* kPath = "/user/hand/right/input/trigger/value";
  FakeService service;
  App app(Unattached({XR_VALVE_ANALOG_THRESHOLD_EXTENSION_NAME}));
  const XrHapticVibration pulse{XR_TYPE_HAPTIC_VIBRATION, nullptr, 7'000'000, 90.0f, 0.25f};
  auto threshold = Threshold(app, app.select, kPath, 0.6f, 0.5f);
  threshold.onHaptic = static_cast<const XrHapticBaseHeader*>(static_cast<const void*>(&pulse));
  ASSERT_EQ(SuggestWith(app, kTouch, app.select, kPath, &threshold), XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  service.Set(InputIndex::kTipForce, 0.3f);
  Step(app, service);
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState);
  service.Set(InputIndex::kTipForce, 0.7f);
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
  ASSERT_TRUE(app.SyncUntil(service, [&] { return !service.heard().haptics.empty(); }));
  ASSERT_EQ(service.heard().haptics.size(), 1u);
  EXPECT_EQ(service.heard().haptics[0].duration_ns, 7'000'000);
  EXPECT_FLOAT_EQ(service.heard().haptics[0].amplitude, 0.25f);
}

// A profile that only the layer knows: the extension's errors are the layer's.
TEST_F(StatesRules, InvalidThresholdsAreRejected) {
  constexpr const char* kPath = "/user/hand/right/input/trigger/value";
  const App app(Unattached({"XR_KHR_generic_controller", XR_VALVE_ANALOG_THRESHOLD_EXTENSION_NAME}));
  for (const char* profile : {kGeneric, kTouch}) {
    auto threshold = Threshold(app, app.select, kPath, 0.3f, 0.6f);
    EXPECT_EQ(SuggestWith(app, profile, app.select, kPath, &threshold), XR_ERROR_VALIDATION_FAILURE) << profile;
    threshold = Threshold(app, app.squeeze, kPath, 0.6f, 0.3f);
    EXPECT_EQ(SuggestWith(app, profile, app.select, kPath, &threshold), XR_ERROR_PATH_UNSUPPORTED) << profile;
    threshold = Threshold(app, app.select, kPath, 0.6f, 0.3f);
    EXPECT_EQ(SuggestWith(app, profile, app.select, kPath, &threshold), XR_SUCCESS) << profile;
  }
}

// [XrActionStateBoolean] the pen takes over a hand whose controller was pressed: that is a change, at that sync.
TEST_F(StatesRules, PenTakeoverReportsStateChange) {
  omni_test_set_device("right", 1, kTouch);
  App app;
  omni_test_set_float("/user/hand/right/input/trigger/value", 1.0f);
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  ASSERT_TRUE(app.Bool(app.select, app.right).currentState);
  const XrTime held_since = app.Bool(app.select, app.right).lastChangeTime;
  FakeService service;
  bool changed = false;
  ASSERT_TRUE(app.SyncUntil(service, [&] {
    const XrActionStateBoolean state = app.Bool(app.select, app.right);
    changed = state.changedSinceLastSync == XR_TRUE;
    return !state.currentState;
  }));
  EXPECT_TRUE(changed) << "true before, false now";
  EXPECT_GT(app.Bool(app.select, app.right).lastChangeTime, held_since);
  Step(app, service);
  EXPECT_FALSE(app.Bool(app.select, app.right).changedSinceLastSync);
}

// [input-state-sync] presses made while another application had the focus are not reported.
TEST_F(StatesRules, PressesWithoutFocusAreNotReported) {
  for (const bool synced_meanwhile : {true, false}) {
    FakeService service;
    App app;
    ASSERT_TRUE(app.WaitProfile(service, kTouch));
    omni_test_set_focus(0);
    app.Poll();
    if (synced_meanwhile) {
      service.Fill();
      EXPECT_EQ(app.Sync(), XR_SESSION_NOT_FOCUSED);
    }
    service.Set(InputIndex::kSelect, 1);
    service.Set(InputIndex::kSelect, 0);
    omni_test_set_focus(1);
    app.Poll();
    Step(app, service);
    EXPECT_TRUE(app.Bool(app.select, app.right).isActive);
    EXPECT_FALSE(app.Bool(app.select, app.right).currentState) << synced_meanwhile;
  }
}

// [input-creating-actions] a destroyed action still counts in priorities and spaces of the session it is attached to.
TEST_F(StatesRules, DestroyedActionStillTakesItsSource) {
  FakeService service;
  App app(Unattached());
  const TwoSets sets(app, 5);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  ASSERT_EQ(xrDestroyAction(sets.grab), XR_SUCCESS);
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, XR_NULL_PATH}, {sets.second, XR_NULL_PATH}}), XR_SUCCESS);
  EXPECT_FALSE(app.Bool(app.select, app.right).isActive) << "the higher set's action takes the trigger";
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.select, app.right).isActive);
}

// ... destroyed before its set was attached, it does not.
TEST_F(StatesRules, ActionDestroyedBeforeAttachTakesNoSource) {
  FakeService service;
  App app(Unattached());
  const XrActionSet high = app.MakeSet("high", 5);
  const XrAction grab = app.MakeAction(high, "grab", XR_ACTION_TYPE_BOOLEAN_INPUT);
  const XrAction other = app.MakeAction(high, "other", XR_ACTION_TYPE_BOOLEAN_INPUT);
  ASSERT_EQ(app.Suggest(kTouch, {{app.select, "/user/hand/right/input/trigger/value"},
                                 {other, "/user/hand/right/input/a/click"},
                                 {grab, "/user/hand/right/input/trigger/value"}}),
            XR_SUCCESS);
  ASSERT_EQ(xrDestroyAction(grab), XR_SUCCESS);
  ASSERT_EQ(AttachSets(app, {app.set, high}), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, XR_NULL_PATH}, {high, XR_NULL_PATH}}), XR_SUCCESS);
  EXPECT_TRUE(app.Bool(app.select, app.right).isActive);
  EXPECT_TRUE(app.Bool(other, app.right).isActive);
}

// [input-state-sync] no active set: a success, and everything is inactive and zero.
TEST_F(StatesRules, SyncWithoutSetsMakesStatesInactive) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  Step(app, service);
  ASSERT_TRUE(app.Bool(app.select, app.right).currentState);
  service.Fill();
  ASSERT_EQ(app.SyncSets({}), XR_SUCCESS);
  const XrActionStateBoolean state = app.Bool(app.select, app.right);
  EXPECT_FALSE(state.isActive || state.currentState || state.changedSinceLastSync);
  EXPECT_EQ(state.lastChangeTime, 0);
  EXPECT_EQ(app.Profile(app.right), kTouch) << "the device is still present";
}

// [input-state-sync] errors of xrSyncActions change nothing of the pen's states.
TEST_F(StatesRules, FailedSyncChangesNothing) {
  FakeService service;
  App app;
  const XrActionSet loose = app.MakeSet("loose", 0);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  service.Fill();
  EXPECT_EQ(app.SyncSets({{loose, XR_NULL_PATH}}), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  EXPECT_EQ(app.SyncSets({{app.set, app.Path("/user/gamepad")}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(app.SyncSets({{app.set, 987654321}}), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(xrSyncActions(app.session, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_TRUE(app.Bool(app.select, app.right).isActive);
  EXPECT_FALSE(app.Bool(app.select, app.right).currentState);
}

// An action without subaction paths that is bound to the pen's hand only: the runtime's controller there is ignored.
TEST_F(StatesRules, PensHandActionIgnoresRuntimeController) {
  omni_test_set_device("right", 1, kTouch);
  FakeService service;
  App app;
  ASSERT_TRUE(app.SyncUntil(service, [&] {
    service.Set(InputIndex::kTipForce, 0.5f);
    return app.Float(app.force, app.right).currentState > 0.4f;
  }));
  omni_test_set_bool("/user/hand/right/input/a/click", 1);
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.plain, XR_NULL_PATH).isActive);
  EXPECT_FALSE(app.Bool(app.plain, XR_NULL_PATH).currentState) << "the controller's button";
  service.Set(InputIndex::kSecondary, 1);
  Step(app, service);
  EXPECT_TRUE(app.Bool(app.plain, XR_NULL_PATH).currentState) << "the pen's";
}

}  // namespace test_states_rules
}  // namespace omni::test
