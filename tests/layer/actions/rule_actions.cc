// Rules of the action system that states.cc and profiles.cc do not cover, and events.
#include <gtest/gtest.h>

#include "tests/layer/actions/states_fixture.h"
#include "tests/layer/mini_loader/chain_app.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_rule_actions {

using protocol::InputIndex;

class RuleActions : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
};
using RuleEvents = RuleActions;

AppOptions Unattached() {
  AppOptions options;
  options.attach = false;
  return options;
}

TEST_F(RuleActions, PriorityOverrideHoldsForOneSync) {
  FakeService service;
  App app(Unattached());
  const TwoSets two(app, 5);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kSelect, 1);
  const XrActiveActionSet active[] = {{app.set, XR_NULL_PATH}, {two.second, XR_NULL_PATH}};
  const XrActiveActionSetPriorityEXT lifted{app.set, 9};
  const XrActiveActionSetPrioritiesEXT priorities{XR_TYPE_ACTIVE_ACTION_SET_PRIORITIES_EXT, nullptr, 1, &lifted};
  for (int i = 0; i < 2; ++i) {
    service.Fill();
    XrActionsSyncInfo sync{XR_TYPE_ACTIONS_SYNC_INFO, nullptr, 2, active};
    ASSERT_EQ(xrSyncActions(app.session, &sync), XR_SUCCESS);
    EXPECT_FALSE(app.Bool(app.select, app.right).isActive);
    EXPECT_TRUE(app.Bool(two.grab, app.right).currentState);
    sync.next = &priorities;
    ASSERT_EQ(xrSyncActions(app.session, &sync), XR_SUCCESS);
    EXPECT_TRUE(app.Bool(app.select, app.right).currentState) << "lifted over the other";
    EXPECT_FALSE(app.Bool(two.grab, app.right).isActive);
  }
}

// Suggestions belong to the instance: valid, and recorded, before any session.
TEST_F(RuleActions, SuggestionsBeforeTheSessionCount) {
  FakeService service;
  const MiniLoader loader({OmniLayer()});
  ChainOptions idle;
  idle.begin = false;
  ChainApp app(loader, idle);
  ASSERT_EQ(app.f.DestroySession(app.session), XR_SUCCESS);
  ASSERT_EQ(app.Suggest(kTouch, {{app.force, app.Path("/user/hand/right/input/trigger/value")}}), XR_SUCCESS);
  const XrSessionCreateInfo create{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, app.system};
  ASSERT_EQ(app.f.CreateSession(app.instance, &create, &app.session), XR_SUCCESS);
  const XrSessionActionSetsAttachInfo attach{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr, 1, &app.set};
  ASSERT_EQ(app.f.AttachSessionActionSets(app.session, &attach), XR_SUCCESS);
  ASSERT_TRUE(Eventually([&] {
    app.Poll();
    return app.state == XR_SESSION_STATE_FOCUSED;
  }));
  EXPECT_TRUE(app.WaitProfile(service, kTouch));
}

TEST_F(RuleActions, StatesAndProfileDoNotChangeBetweenSyncs) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kTipForce, 0.25f);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  const XrActionStateFloat synced = app.Float(app.force, app.right);
  EXPECT_FLOAT_EQ(synced.currentState, 0.25f);
  service.Set(InputIndex::kTipForce, 0.75f);
  service.SetFlags(0);
  service.Fill();
  app.Poll();
  const XrActionStateFloat later = app.Float(app.force, app.right);
  EXPECT_FLOAT_EQ(later.currentState, 0.25f);
  EXPECT_EQ(later.isActive, synced.isActive);
  EXPECT_EQ(later.lastChangeTime, synced.lastChangeTime);
  EXPECT_EQ(later.changedSinceLastSync, synced.changedSinceLastSync);
  EXPECT_EQ(app.Profile(app.right), kTouch);
}

// The runtime may have reused the handle for another action by now.
TEST_F(RuleActions, DestroyedActionIsNotQueriedInRuntime) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const auto asked_in_a_sync = [&] {
    const long before = omni_test_call_count("xrGetActionStatePose");
    service.Fill();
    EXPECT_EQ(app.Sync(), XR_SUCCESS);
    return omni_test_call_count("xrGetActionStatePose") - before;
  };
  EXPECT_GT(asked_in_a_sync(), 0);
  ASSERT_EQ(xrDestroyAction(app.pose), XR_SUCCESS);
  EXPECT_EQ(asked_in_a_sync(), 0);
}

TEST_F(RuleActions, InvalidSyncFailsAndKeepsStates) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  service.Set(InputIndex::kTipForce, 0.5f);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(app.SyncSets({{app.set, app.Path("/user/gamepad")}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(app.SyncSets({{app.set, 987654321}}), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(app.SyncSets({{XR_NULL_HANDLE, XR_NULL_PATH}}), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(app.SyncSets({{app.MakeSet("late", 0), XR_NULL_PATH}}), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.5f) << "a failed sync changes nothing";
  service.Fill();
  ASSERT_EQ(app.SyncSets({{app.set, app.left}}), XR_SUCCESS);
  EXPECT_FALSE(app.Float(app.force, app.right).isActive) << "active for the other hand";
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_TRUE(app.Float(app.force, app.right).isActive);
  ASSERT_EQ(app.SyncSets({}), XR_SUCCESS);
  const XrActionStateFloat none = app.Float(app.force, app.right);
  EXPECT_FALSE(none.isActive) << "no set is active";
  EXPECT_FLOAT_EQ(none.currentState, 0.0f);
  EXPECT_EQ(none.lastChangeTime, 0);
}

// [xrLocateSpace] an inactive space in an invalid base: the runtime's error.
TEST_F(RuleActions, LocatingInactiveSpaceInInvalidBaseFails) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const XrSpace pen = app.ActionSpace(app.pose, app.right);
  ASSERT_EQ(app.SyncSets({}), XR_SUCCESS);
  const auto bogus = reinterpret_cast<XrSpace>(std::uint64_t{0xdead0000beef0000});
  for (const XrSpace base : {XrSpace{XR_NULL_HANDLE}, bogus}) {
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
    EXPECT_EQ(xrLocateSpace(pen, base, Now_ns() + kRuntimeOffset_ns, &location), XR_ERROR_HANDLE_INVALID);
    EXPECT_EQ(xrLocateSpace(base, pen, Now_ns() + kRuntimeOffset_ns, &location), XR_ERROR_HANDLE_INVALID);
  }
}

// [XrEventDataInteractionProfileChanged]
TEST_F(RuleEvents, NoProfileEventBeforeSync) {
  FakeService service;
  App app;
  ASSERT_TRUE(Eventually([&] {
    service.Fill();
    app.Poll();
    return !service.heard().sessions.empty();
  })) << "connected";
  for (int i = 0; i < 10; ++i) {
    service.Fill();
    app.Poll();
  }
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 0);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  app.Poll();
  EXPECT_GE(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 1);
}

TEST_F(RuleEvents, NoProfileEventForDestroyedSession) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  app.Poll();
  app.events.clear();
  // The pen goes: an event is due. The session ends before it is polled.
  service.SetFlags(0);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  ASSERT_EQ(app.Profile(app.right), "");
  ASSERT_EQ(xrDestroySession(app.session), XR_SUCCESS);
  app.Poll();
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 0);
}

}  // namespace test_rule_actions
}  // namespace omni::test
