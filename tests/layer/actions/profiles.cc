// Suggested bindings, and which profile is current when.
#include <gtest/gtest.h>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_profiles {

class Profiles : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
};

// [input-suggested-bindings] a profile that only the layer knows is validated as the runtime validates its own.
TEST_F(Profiles, MxInkIsValidatedByTheLayer) {
  AppOptions options;
  options.mx_ink_extension = true;
  options.attach = false;
  options.begin = false;
  App app(options);
  EXPECT_EQ(app.SuggestUsual(kMxInk), XR_SUCCESS);
  EXPECT_EQ(app.Suggest(kMxInk, {}), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(app.Suggest(kMxInk, {{XR_NULL_HANDLE, "/user/hand/right/input/tip_logitech/force"}}),
            XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(app.Suggest(kMxInk, {{app.select, "/user/hand/right/input/trigger/value"}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(app.Suggest(kMxInk, {{app.select, "/user/gamepad/input/tip_logitech/force"}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(app.Suggest(kMxInk, {{app.pose, "/user/hand/right/input/grip_surface/pose"}}), XR_ERROR_PATH_UNSUPPORTED)
      << "needs XR_KHR_maintenance1 or OpenXR 1.1";
  const XrActionSuggestedBinding bogus{app.select, 987654321};
  const XrInteractionProfileSuggestedBinding info{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr,
                                                  app.Path(kMxInk), 1, &bogus};
  EXPECT_EQ(xrSuggestInteractionProfileBindings(app.instance, &info), XR_ERROR_PATH_INVALID);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  EXPECT_EQ(app.SuggestUsual(kMxInk), XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
}

TEST_F(Profiles, MxInkWithoutItsExtensionIsUnsupported) {
  AppOptions options;
  options.attach = false;
  options.begin = false;
  const App app(options);
  EXPECT_EQ(app.SuggestUsual(kMxInk), XR_ERROR_PATH_UNSUPPORTED);
}

// Accepted with the service absent too, so that the pen can come back; but never current.
TEST_F(Profiles, MxInkIsAcceptedButNotCurrentWithoutService) {
  AppOptions options;
  options.mx_ink_extension = true;
  options.profiles = {kMxInk};
  App app(options);
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_EQ(app.Profile(app.right), "");
  FakeService service;
  EXPECT_TRUE(app.WaitProfile(service, kMxInk)) << "the service came later";
}

TEST_F(Profiles, BestSuggestedProfileBecomesCurrent) {
  FakeService service;
  AppOptions options;
  options.mx_ink_extension = true;
  options.profiles = {kSimple, kMxInk, kTouch};
  App app(options);
  EXPECT_TRUE(app.WaitProfile(service, kMxInk));
  EXPECT_EQ(app.Profile(app.left), kTouch) << "the runtime's device has its own profile";
}

TEST_F(Profiles, TouchIsPreferredToSimple) {
  FakeService service;
  AppOptions options;
  options.profiles = {kSimple, kTouch};
  App app(options);
  EXPECT_TRUE(app.WaitProfile(service, kTouch));
}

TEST_F(Profiles, SimpleBecomesCurrentWhenSuggestedAlone) {
  FakeService service;
  AppOptions options;
  options.profiles = {kSimple};
  App app(options);
  EXPECT_TRUE(app.WaitProfile(service, kSimple));
}

// A profile whose bindings name only the other hand is skipped for the pen; the next one is used.
TEST_F(Profiles, ProfileWithoutBindingsForPensHandIsSkipped) {
  FakeService service;
  AppOptions options;
  options.attach = false;
  App app(options);
  ASSERT_EQ(app.Suggest(kTouch, {{app.select, "/user/hand/left/input/trigger/value"}}), XR_SUCCESS);
  ASSERT_EQ(app.SuggestUsual(kSimple), XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  EXPECT_TRUE(app.WaitProfile(service, kSimple));
}

// [input-suggested-bindings] the second suggestion for a profile replaces the first.
TEST_F(Profiles, SecondSuggestionReplacesTheFirst) {
  FakeService service;
  AppOptions options;
  options.attach = false;
  App app(options);
  ASSERT_EQ(app.SuggestUsual(kTouch), XR_SUCCESS);
  ASSERT_EQ(app.Suggest(kTouch, {{app.unbound, "/user/hand/right/input/trigger/value"}}), XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  EXPECT_TRUE(app.Bool(app.unbound, app.right).isActive);
  EXPECT_FALSE(app.Bool(app.select, app.right).isActive);
}

// A suggestion that the runtime rejects does not count.
TEST_F(Profiles, RefusedSuggestionIsNotRecorded) {
  FakeService service;
  AppOptions options;
  options.attach = false;
  App app(options);
  ASSERT_EQ(app.SuggestUsual(kSimple), XR_SUCCESS);
  ASSERT_EQ(app.Suggest(kTouch, {{app.select, "/user/hand/right/input/trigger/value"},
                                 {app.select, "/user/hand/right/input/x/click"}}),
            XR_ERROR_PATH_UNSUPPORTED);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  EXPECT_TRUE(app.WaitProfile(service, kSimple));
}

// [input-current-interaction-profile] selection changes only in xrSyncActions, with one event.
TEST_F(Profiles, ProfileChangesOnlyInSyncWithOneEvent) {
  FakeService service;
  App app;
  for (int i = 0; i < 50; ++i) {  // time enough to connect, but no sync
    service.Fill();
    app.Poll();
    EXPECT_EQ(app.Profile(app.right), "");
    const timespec pause{0, 5'000'000};
    nanosleep(&pause, nullptr);
    if (!service.heard().applications.empty() && i > 10) break;
  }
  app.events.clear();
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  app.Poll();
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 1)
      << "the left hand's change and the pen's are one event";
  for (int i = 0; i < 20; ++i) {
    service.Fill();
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    app.Poll();
  }
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 1) << "no event without a change";
}

TEST_F(Profiles, EventWhenThePenComesLater) {
  App app;
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  app.Poll();
  app.events.clear();
  FakeService service;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  app.Poll();
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 1);
}

// Before the first focused sync no profile is current.
TEST_F(Profiles, UnfocusedSyncDoesNotSelectProfile) {
  App app;
  omni_test_set_focus(0);
  app.Poll();
  FakeService service;
  for (int i = 0; i < 1000 && service.heard().sessions.empty(); ++i) {
    service.Fill();
    ASSERT_EQ(app.Sync(), XR_SESSION_NOT_FOCUSED);
    const timespec pause{0, 5'000'000};
    nanosleep(&pause, nullptr);
  }
  ASSERT_FALSE(service.heard().sessions.empty()) << "connected";
  for (int i = 0; i < 100; ++i) {  // long enough for a pen that waits for its base pose
    service.Fill();
    ASSERT_EQ(app.Sync(), XR_SESSION_NOT_FOCUSED);
    const timespec pause{0, 5'000'000};
    nanosleep(&pause, nullptr);
  }
  EXPECT_EQ(app.Profile(app.right), "");
}

// The runtime shows the same profile for that hand: nothing changed for the application.
TEST_F(Profiles, NoEventWhenProfileStaysTheSame) {
  omni_test_set_device("right", 1, kTouch);
  App app;
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  app.Poll();
  app.events.clear();
  FakeService service;
  ASSERT_TRUE(app.SyncUntil(service, [&] {
    service.Set(protocol::InputIndex::kTipForce, 0.5f);
    return app.Float(app.force, app.right).currentState > 0.4f;
  }));
  app.Poll();
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 0);
}

// [input-current-interaction-profile] errors are the runtime's, pen or no pen.
TEST_F(Profiles, CurrentProfileRejectsInvalidArguments) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  EXPECT_EQ(xrGetCurrentInteractionProfile(app.session, XR_NULL_PATH, &state), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(xrGetCurrentInteractionProfile(app.session, 987654321, &state), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(xrGetCurrentInteractionProfile(app.session, app.Path("/user/hand"), &state), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(xrGetCurrentInteractionProfile(app.session, app.right, nullptr), XR_ERROR_VALIDATION_FAILURE);
}

TEST_F(Profiles, UnattachedSessionHasNoProfile) {
  FakeService service;
  AppOptions options;
  options.attach = false;
  App app(options);
  XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
  EXPECT_EQ(xrGetCurrentInteractionProfile(app.session, app.right, &state), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  EXPECT_EQ(app.Sync(), XR_ERROR_ACTIONSET_NOT_ATTACHED);
  EXPECT_EQ(app.SyncSets({}), XR_SUCCESS);
}

// [input-bound-sources] the pen's sources are listed with names; other hands' stay; unbound: none.
TEST_F(Profiles, BoundSourcesIncludeThePenWithLocalizedNames) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const auto sources = [&](XrAction action) {
    const XrBoundSourcesForActionEnumerateInfo info{XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO, nullptr, action};
    std::uint32_t count = 0;
    EXPECT_EQ(xrEnumerateBoundSourcesForAction(app.session, &info, 0, &count, nullptr), XR_SUCCESS);
    std::vector<XrPath> paths(count + 1);
    if (count > 1) {
      EXPECT_EQ(xrEnumerateBoundSourcesForAction(app.session, &info, 1, &count, paths.data()),
                XR_ERROR_SIZE_INSUFFICIENT);
    }
    EXPECT_EQ(xrEnumerateBoundSourcesForAction(app.session, &info, count, &count, paths.data()), XR_SUCCESS);
    paths.resize(count);
    return paths;
  };
  EXPECT_EQ(sources(app.select).size(), 2u);
  EXPECT_EQ(sources(app.unbound).size(), 0u);
  const XrPath pen = sources(app.select).back();
  EXPECT_EQ(app.Text(pen), "/user/hand/right/input/trigger/value");
  const auto name = [&](XrInputSourceLocalizedNameFlags which) {
    const XrInputSourceLocalizedNameGetInfo info{XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO, nullptr, pen, which};
    char text[256] = {};
    std::uint32_t length = 0;
    EXPECT_EQ(xrGetInputSourceLocalizedName(app.session, &info, 256, &length, text), XR_SUCCESS);
    EXPECT_EQ(length, std::string(text).size() + 1);
    return std::string(text);
  };
  EXPECT_EQ(name(1), "Right hand");
  EXPECT_EQ(name(2), "Omni pen as Touch controller");
  EXPECT_EQ(name(4), "Tip force");
  EXPECT_EQ(name(7), "Right hand Omni pen as Touch controller Tip force");
  const XrInputSourceLocalizedNameGetInfo none{XR_TYPE_INPUT_SOURCE_LOCALIZED_NAME_GET_INFO, nullptr, pen, 0};
  std::uint32_t length = 0;
  EXPECT_EQ(xrGetInputSourceLocalizedName(app.session, &none, 0, &length, nullptr), XR_ERROR_VALIDATION_FAILURE);
}

}  // namespace test_profiles
}  // namespace omni::test
