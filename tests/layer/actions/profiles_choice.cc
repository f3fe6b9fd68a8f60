// Profiles and paths that only the layer knows, and how a profile is chosen.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>

#include "layer/src/spaces/pose_math.h"
#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_profiles_choice {

using protocol::InputIndex;

constexpr const char* kStylusExtension = "XR_OMNIX1_stylus_interaction";
constexpr const char* kGenericExtension = "XR_KHR_generic_controller";

class ProfilesChoice : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
  void TearDown() override {
    unsetenv("OMNI_PROFILE");
    unsetenv("OMNI_HAND");
    unsetenv("OMNI_TEST_RUNTIME_EXTENSIONS");
  }
  static AppOptions Unattached(std::vector<const char*> extensions = {}) {
    AppOptions options;
    options.attach = false;
    options.extensions = std::move(extensions);
    return options;
  }
};

protocol::AppSettings Settings(protocol::HandSetting hand, const char* profile) {
  protocol::AppSettings settings;
  settings.hand = hand;
  std::snprintf(settings.profile, sizeof(settings.profile), "%s", profile);
  return settings;
}

std::vector<Bound> StylusBindings(const App& app) {
  return {
      {app.select, "/user/hand/right/input/tip_omnix1/click"}, {app.force, "/user/hand/right/input/tip_omnix1/force"},
      {app.pose, "/user/hand/right/input/tip_omnix1/pose"},    {app.squeeze, "/user/hand/right/input/barrel_omnix1"},
      {app.stick, "/user/hand/right/input/thumbstick"},        {app.haptic, "/user/hand/right/output/haptic"}};
}

TEST_F(ProfilesChoice, OmniStylusProfileIsPreferred) {
  FakeService service;
  AppOptions options = Unattached({kStylusExtension});
  options.mx_ink_extension = true;
  App app(options);
  ASSERT_EQ(app.SuggestUsual(kMxInk), XR_SUCCESS);
  ASSERT_EQ(app.SuggestUsual(kTouch), XR_SUCCESS);
  ASSERT_EQ(app.Suggest(kOmniStylus, StylusBindings(app)), XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kOmniStylus));
  service.Set(InputIndex::kTipForce, 0.3f);
  service.Set(InputIndex::kSelect, 1);
  service.Set(InputIndex::kSecondary, 1);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.3f);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState);
  EXPECT_TRUE(app.Bool(app.squeeze, app.right).currentState) << "the barrel, by its parent path";
  EXPECT_TRUE(app.PoseActive(app.pose, app.right));
}

TEST_F(ProfilesChoice, OmniStylusProfileNeedsItsExtension) {
  const App app(Unattached());
  EXPECT_EQ(app.Suggest(kOmniStylus, StylusBindings(app)), XR_ERROR_PATH_UNSUPPORTED);
}

TEST_F(ProfilesChoice, OmniStylusSuggestionsAreValidated) {
  const App app(Unattached({kStylusExtension}));
  EXPECT_EQ(app.Suggest(kOmniStylus, {}), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(app.Suggest(kOmniStylus, {{app.select, "/user/hand/right/input/trigger/value"}}),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(app.Suggest(kOmniStylus, {{app.select, "/user/hand/right/input/tip_omnix1/nonsense"}}),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(app.Suggest(kOmniStylus, {{XR_NULL_HANDLE, "/user/hand/right/input/tip_omnix1/click"}}),
            XR_ERROR_HANDLE_INVALID);
}

// XR_KHR_generic_controller where the runtime lacks it.
TEST_F(ProfilesChoice, GenericControllerWorksOnRuntimeWithoutIt) {
  FakeService service;
  App app(Unattached({kGenericExtension}));
  ASSERT_EQ(app.SuggestUsual(kTouch), XR_SUCCESS);
  EXPECT_EQ(app.Suggest(kGeneric, {{app.select, "/user/hand/left/input/x/click"}}), XR_ERROR_PATH_UNSUPPORTED);
  ASSERT_EQ(app.Suggest(kGeneric, {{app.pose, "/user/hand/right/input/grip_surface/pose"},
                                   {app.select, "/user/hand/right/input/primary/click"},
                                   {app.force, "/user/hand/right/input/trigger/value"},
                                   {app.stick, "/user/hand/right/input/thumbstick"}}),
            XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kGeneric));
  EXPECT_EQ(app.Profile(app.left), kTouch) << "the other hand's controller has a profile that the runtime knows";
  service.Set(InputIndex::kSecondary, 1);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState) << "primary";
}

TEST_F(ProfilesChoice, IndexIsPreferredToSimpleAndTrackpadIsAtRest) {
  FakeService service;
  App app(Unattached());
  ASSERT_EQ(app.Suggest(kIndex, {{app.select, "/user/hand/right/input/trigger/click"},
                                 {app.force, "/user/hand/right/input/trackpad/force"}}),
            XR_SUCCESS);
  ASSERT_EQ(app.SuggestUsual(kSimple), XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kIndex));
  const XrActionStateFloat trackpad = app.Float(app.force, app.right);
  EXPECT_TRUE(trackpad.isActive) << "bound, and at rest";
  EXPECT_EQ(trackpad.currentState, 0.0f);
}

// A path of ours on a profile of the runtime's does not break the call; only paths that the runtime knows are passed
// down.
TEST_F(ProfilesChoice, TipPathsWorkOnRuntimeProfile) {
  FakeService service;
  App app(Unattached({kStylusExtension}));
  ASSERT_EQ(app.Suggest(kTouch, {{app.pose, "/user/hand/right/input/tip_omnix1/pose"},
                                 {app.pose, "/user/hand/left/input/tip_omnix1/pose"},
                                 {app.force, "/user/hand/right/input/tip_omnix1/force"},
                                 {app.select, "/user/hand/left/input/trigger/value"}}),
            XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  EXPECT_TRUE(app.PoseActive(app.pose, app.right));
  EXPECT_FALSE(app.PoseActive(app.pose, app.left)) << "the runtime's controller has no tip";
  service.Set(InputIndex::kTipForce, 0.7f);
  omni_test_set_float("/user/hand/left/input/trigger/value", 1.0f);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.7f);
  EXPECT_TRUE(app.Bool(app.select, app.left).currentState) << "the runtime has received its part of the suggestion";
}

TEST_F(ProfilesChoice, TipPathsNeedTheExtension) {
  const App app(Unattached());
  EXPECT_EQ(app.Suggest(kTouch, {{app.pose, "/user/hand/right/input/tip_omnix1/pose"}}), XR_ERROR_PATH_UNSUPPORTED);
}

// The runtime's errors remain with a path of ours beside them, and the reverse.
TEST_F(ProfilesChoice, TipPathsDoNotHideOtherBindingErrors) {
  const App app(Unattached({kStylusExtension}));
  EXPECT_EQ(app.Suggest(kTouch, {{app.pose, "/user/hand/right/input/tip_omnix1/pose"},
                                 {app.select, "/user/hand/right/input/x/click"}}),
            XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(app.Suggest(kTouch, {{XR_NULL_HANDLE, "/user/hand/right/input/tip_omnix1/pose"},
                                 {app.select, "/user/hand/right/input/a/click"}}),
            XR_ERROR_HANDLE_INVALID);
  ASSERT_EQ(app.SuggestUsual(kTouch), XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  EXPECT_EQ(app.Suggest(kTouch, {{app.pose, "/user/hand/right/input/tip_omnix1/pose"}}),
            XR_ERROR_ACTIONSETS_ALREADY_ATTACHED);
}

// Of two extensions that may be below, the one that the runtime has is requested from it and left to it.
TEST_F(ProfilesChoice, ProfilesOfRuntimeExtensionsAreLeftToTheRuntime) {
  for (const char* below : {kGenericExtension, XR_LOGITECH_MX_INK_STYLUS_INTERACTION_EXTENSION_NAME}) {
    setenv("OMNI_TEST_RUNTIME_EXTENSIONS", below, 1);
    AppOptions options = Unattached({kGenericExtension});
    options.mx_ink_extension = true;
    const App app(options);
    const bool generic_below = below == kGenericExtension;
    // The runtime accepts the name but knows no such profile: its error shows that it was called.
    EXPECT_EQ(app.Suggest(kGeneric, {{app.force, "/user/hand/right/input/trigger/value"}}),
              generic_below ? XR_ERROR_PATH_UNSUPPORTED : XR_SUCCESS);
    EXPECT_EQ(app.SuggestUsual(kMxInk), generic_below ? XR_SUCCESS : XR_ERROR_PATH_UNSUPPORTED);
  }
}

// XR_EXT_dpad_binding: accepted on the sticks of a profile that only the layer knows, without effect for the pen.
TEST_F(ProfilesChoice, DpadPathsAreAcceptedButInactiveForThePen) {
  constexpr const char* kDpad = "/user/hand/right/input/thumbstick/dpad_up";
  {
    const App app(Unattached({kGenericExtension}));
    EXPECT_EQ(app.Suggest(kGeneric, {{app.select, kDpad}}), XR_ERROR_PATH_UNSUPPORTED) << "not enabled";
  }
  setenv("OMNI_TEST_RUNTIME_EXTENSIONS", "XR_EXT_dpad_binding", 1);
  FakeService service;
  App app(Unattached({kGenericExtension, "XR_EXT_dpad_binding"}));
  EXPECT_EQ(app.Suggest(kGeneric, {{app.select, "/user/hand/right/input/trigger/dpad_up"}}), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(app.Suggest(kGeneric, {{app.select, "/user/hand/right/input/thumbstick/dpad_center"}}),
            XR_ERROR_PATH_UNSUPPORTED)
      << "trackpads only";
  ASSERT_EQ(app.Suggest(kGeneric, {{app.select, kDpad}, {app.force, "/user/hand/right/input/trigger/value"}}),
            XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  ASSERT_TRUE(app.WaitProfile(service, kGeneric));
  EXPECT_FALSE(app.Bool(app.select, app.right).isActive);
  EXPECT_TRUE(app.Float(app.force, app.right).isActive);
}

// [semantic-paths-standard-pose-identifiers] x is normal to the palm in both poses; the handle leaves the hand between
// the direction of the straightened finger, -z, and the thumb's side, +y. Limits of the conformance suite.
TEST_F(ProfilesChoice, PalmIsTiltedAgainstTheGrip) {
  constexpr double kMostX_deg = 75, kMostZ_deg = 90, kMostY_deg = 85;
  setenv("OMNI_TEST_RUNTIME_EXTENSIONS", "XR_EXT_palm_pose", 1);
  FakeService service;
  AppOptions options = Unattached({"XR_EXT_palm_pose"});
  options.mx_ink_extension = true;
  App app(options);
  const XrAction grip = app.MakeAction(app.set, "grip", XR_ACTION_TYPE_POSE_INPUT);
  ASSERT_EQ(app.Suggest(kMxInk, {{app.pose, "/user/hand/right/input/palm_ext/pose"},
                                 {grip, "/user/hand/right/input/grip/pose"}}),
            XR_SUCCESS);
  ASSERT_EQ(app.Attach(), XR_SUCCESS);
  ASSERT_TRUE(app.SyncUntil(service, [&] { return app.PoseActive(grip, app.right); }));
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
  ASSERT_EQ(xrLocateSpace(app.ActionSpace(app.pose, app.right), app.ActionSpace(grip, app.right),
                          Now_ns() + kRuntimeOffset_ns, &location),
            XR_SUCCESS);
  ASSERT_NE(location.locationFlags & XR_SPACE_LOCATION_ORIENTATION_VALID_BIT, 0U);
  const glm::dquat q = layer::FromXr(location.pose).q;
  const auto angle_deg = [](const glm::dvec3& a, const glm::dvec3& b) {
    return glm::degrees(std::acos(std::clamp(glm::dot(a, b), -1.0, 1.0)));
  };
  EXPECT_LT(angle_deg({1, 0, 0}, q * glm::dvec3(1, 0, 0)), kMostX_deg);
  EXPECT_LT(angle_deg({0, 0, 1}, q * glm::dvec3(0, 0, 1)), kMostZ_deg);
  EXPECT_LT(angle_deg({0, 0, -1}, q * glm::dvec3(0, 1, 0)), kMostY_deg);
  EXPECT_GE(location.pose.position.x, -1e-4f) << "of a right hand: not left of the pen";
}

// [semantic-paths-standard-pose-identifiers] poses that extensions add exist on every profile, if enabled.
TEST_F(ProfilesChoice, ExtensionPosesAreAcceptedOnLayersProfile) {
  const std::pair<const char*, const char*> rows[] = {
      {"XR_EXT_palm_pose", "/user/hand/right/input/palm_ext/pose"},
      {"XR_EXT_hand_interaction", "/user/hand/right/input/poke_ext"},
      {"XR_KHR_maintenance1", "/user/hand/left/input/grip_surface/pose"}};
  for (const auto& [extension, path] : rows) {
    unsetenv("OMNI_TEST_RUNTIME_EXTENSIONS");
    AppOptions options = Unattached();
    options.mx_ink_extension = true;
    {
      const App app(options);
      EXPECT_EQ(app.Suggest(kMxInk, {{app.pose, path}}), XR_ERROR_PATH_UNSUPPORTED) << path;
    }
    setenv("OMNI_TEST_RUNTIME_EXTENSIONS", extension, 1);
    options.extensions = {extension};
    const App app(options);
    EXPECT_EQ(app.Suggest(kMxInk, {{app.pose, path}}), XR_SUCCESS) << path;
  }
}

TEST_F(ProfilesChoice, EnvironmentPinsTheProfile) {
  setenv("OMNI_PROFILE", "khr/simple_controller", 1);
  FakeService service;
  AppOptions options;
  options.profiles = {kTouch, kSimple};
  App app(options);
  EXPECT_TRUE(app.WaitProfile(service, kSimple));
}

TEST_F(ProfilesChoice, UnusablePinFallsBackToBestProfile) {
  for (const char* pin : {"valve/index_controller", "no/such_profile"}) {
    setenv("OMNI_PROFILE", pin, 1);
    FakeService service;
    AppOptions options;
    options.profiles = {kTouch, kSimple};
    App app(options);
    EXPECT_TRUE(app.WaitProfile(service, kTouch)) << pin;
  }
}

// The service's setting applies too, and may change while the session runs: at a sync, with an event.
TEST_F(ProfilesChoice, ServiceCanPinProfileDuringSession) {
  FakeService service;
  AppOptions options;
  options.profiles = {kTouch, kSimple};
  App app(options);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  app.Poll();
  app.events.clear();
  service.Wish(Settings(protocol::HandSetting::kUnset, kSimple));
  ASSERT_TRUE(app.WaitProfile(service, kSimple));
  app.Poll();
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 1);
  service.Set(InputIndex::kSelect, 1);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_TRUE(app.Bool(app.select, app.right).currentState) << "select/click";
  EXPECT_FALSE(app.Float(app.force, app.right).isActive) << "the simple controller has no trigger";
  service.Wish(Settings(protocol::HandSetting::kUnset, ""));
  EXPECT_TRUE(app.WaitProfile(service, kTouch));
}

TEST_F(ProfilesChoice, EnvironmentChoosesTheHand) {
  setenv("OMNI_HAND", "left", 1);
  FakeService service;
  App app;
  ASSERT_TRUE(app.SyncUntil(service, [&] {
    service.Set(InputIndex::kTipForce, 0.6f);
    return app.Float(app.force, app.left).currentState > 0.5f;
  }));
  EXPECT_EQ(app.Profile(app.right), "") << "no controller there";
}

// The pen changes hands at a sync: states, profile, spaces and bound sources follow together.
TEST_F(ProfilesChoice, ServiceMovesThePenToTheOtherHand) {
  omni_test_set_device("left", 0, nullptr);
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const XrSpace left = app.ActionSpace(app.pose, app.left);
  const XrSpace right = app.ActionSpace(app.pose, app.right);
  const XrSpace local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  const auto located = [&](XrSpace space) {
    XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
    EXPECT_EQ(xrLocateSpace(space, local, Now_ns() + kRuntimeOffset_ns, &location), XR_SUCCESS);
    return (location.locationFlags & XR_SPACE_LOCATION_POSITION_VALID_BIT) != 0;
  };
  service.Set(InputIndex::kSelect, 1);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  ASSERT_TRUE(app.Bool(app.select, app.right).currentState);
  EXPECT_TRUE(located(right));
  EXPECT_FALSE(located(left));
  app.Poll();
  app.events.clear();
  service.Wish(Settings(protocol::HandSetting::kLeft, ""));
  ASSERT_TRUE(app.SyncUntil(service, [&] { return app.PoseActive(app.pose, app.left); }));
  EXPECT_EQ(app.Profile(app.left), kTouch);
  EXPECT_EQ(app.Profile(app.right), "");
  EXPECT_TRUE(app.Bool(app.select, app.left).currentState) << "still held";
  EXPECT_FALSE(app.Bool(app.select, app.right).isActive);
  EXPECT_EQ(app.Bool(app.select, app.right).lastChangeTime, 0) << "inactive";
  EXPECT_TRUE(located(left));
  EXPECT_FALSE(located(right));
  const XrBoundSourcesForActionEnumerateInfo info{XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO, nullptr, app.select};
  std::uint32_t count = 0;
  XrPath sources[4] = {};
  ASSERT_EQ(xrEnumerateBoundSourcesForAction(app.session, &info, 4, &count, sources), XR_SUCCESS);
  ASSERT_EQ(count, 1u);
  EXPECT_EQ(app.Text(sources[0]), "/user/hand/left/input/trigger/value");
  app.Poll();
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_PROFILE_CHANGED), 1) << "one event for both hands";
}

}  // namespace test_profiles_choice
}  // namespace omni::test
