// Without a service the layer must be transparent: the same calls over the runtime alone and through the layer.
#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_pass_through {

// A list of "call -> result", free of handles and times.
class Transcript {
 public:
  explicit Transcript(bool layer) {
    omni_test_reset();
    AppOptions options;
    options.layer = layer;
    options.attach = false;
    options.begin = false;
    App app(options);
    Suggestions(app);
    Unattached(app);
    Say("attach", app.Attach());
    Say("attach again", app.Attach());
    Say("suggest after attach", app.SuggestUsual(kTouch));
    Say("sync before begin", app.Sync());
    app.PollUntilFocused();
    Say("sync", app.Sync());
    for (const XrStructureType event : app.events) out_ << "event " << event << '\n';
    app.events.clear();
    States(app);
    Spaces(app);
    Haptics(app);
    Sources(app);
    Focus(app);
  }
  std::string text() const { return out_.str(); }

 private:
  void Say(const std::string& call, XrResult result) { out_ << call << " -> " << result << '\n'; }

  void Suggestions(App& app) {
    for (const char* profile : {kTouch, kSimple, kMxInk}) Say(profile, app.SuggestUsual(profile));
    Say("no such profile", app.Suggest("/interaction_profiles/nobody/nothing", {{app.select, "/user/hand/right"}}));
    Say("no such path", app.Suggest(kTouch, {{app.select, "/user/hand/right/input/nothing/click"}}));
    Say("none", app.Suggest(kTouch, {}));
    Say("null", xrSuggestInteractionProfileBindings(app.instance, nullptr));
    Say("bogus action", app.Suggest(kTouch, {{XR_NULL_HANDLE, "/user/hand/right/input/trigger/value"}}));
    XrInteractionProfileSuggestedBinding bogus{XR_TYPE_INTERACTION_PROFILE_SUGGESTED_BINDING, nullptr, 987654321, 0,
                                               nullptr};
    Say("bogus profile", xrSuggestInteractionProfileBindings(app.instance, &bogus));
  }

  void Profiles(App& app) {
    for (const XrPath path : {app.left, app.right, XrPath{XR_NULL_PATH}, XrPath{987654321}, app.Path("/user/hand"),
                              app.Path("/user/head")}) {
      XrInteractionProfileState state{XR_TYPE_INTERACTION_PROFILE_STATE, nullptr, XR_NULL_PATH};
      const XrResult result = xrGetCurrentInteractionProfile(app.session, path, &state);
      out_ << "profile -> " << result << ' ' << (XR_SUCCEEDED(result) ? app.Text(state.interactionProfile) : "")
           << '\n';
    }
  }

  void Unattached(App& app) {
    Profiles(app);
    States(app);
    Haptics(app);
    Sources(app);
    Say("sync", app.Sync());
  }

  void States(App& app) {
    Profiles(app);
    const XrAction actions[] = {app.pose,   app.select,  app.force, app.stick,     app.squeeze,
                                app.haptic, app.unbound, app.plain, XR_NULL_HANDLE};
    const XrPath paths[] = {XR_NULL_PATH, app.left, app.right, app.Path("/user/gamepad"), 987654321};
    for (const XrAction action : actions) {
      for (const XrPath path : paths) {
        const XrActionStateGetInfo info{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, action, path};
        XrActionStateBoolean b{XR_TYPE_ACTION_STATE_BOOLEAN};
        Say("bool", xrGetActionStateBoolean(app.session, &info, &b));
        XrActionStateFloat f{XR_TYPE_ACTION_STATE_FLOAT};
        Say("float", xrGetActionStateFloat(app.session, &info, &f));
        XrActionStateVector2f v{XR_TYPE_ACTION_STATE_VECTOR2F};
        Say("vector", xrGetActionStateVector2f(app.session, &info, &v));
        XrActionStatePose p{XR_TYPE_ACTION_STATE_POSE};
        Say("pose", xrGetActionStatePose(app.session, &info, &p));
        out_ << b.currentState << b.isActive << b.changedSinceLastSync << f.currentState << f.isActive
             << v.currentState.x << v.isActive << p.isActive << '\n';
      }
    }
    Say("null info", xrGetActionStateBoolean(app.session, nullptr, nullptr));
  }

  void Spaces(App& app) {
    const XrSpace local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
    const XrSpace held[] = {app.ActionSpace(app.pose, app.left), app.ActionSpace(app.pose, app.right),
                            app.ActionSpace(app.pose, XR_NULL_PATH), local, XR_NULL_HANDLE};
    for (const XrSpace a : held) {
      for (const XrSpace b : held) {
        for (const XrTime time : {XrTime{0}, XrTime{-5}, Now_ns() + kRuntimeOffset_ns}) {
          XrSpaceVelocity velocity{XR_TYPE_SPACE_VELOCITY};
          XrSpaceLocation location{XR_TYPE_SPACE_LOCATION, &velocity};
          Say("locate", xrLocateSpace(a, b, time, &location));
          out_ << location.locationFlags << ' ' << velocity.velocityFlags << ' ' << location.pose.position.x << '\n';
        }
      }
    }
    Say("locate into null", xrLocateSpace(local, local, Now_ns() + kRuntimeOffset_ns, nullptr));
    const XrActionSpaceCreateInfo not_a_pose{
        XR_TYPE_ACTION_SPACE_CREATE_INFO, nullptr, app.select, app.left, {{0, 0, 0, 1}, {0, 0, 0}}};
    XrSpace space = XR_NULL_HANDLE;
    Say("space of a boolean", xrCreateActionSpace(app.session, &not_a_pose, &space));
    Say("destroy", xrDestroySpace(held[0]));
  }

  void Haptics(App& app) {
    for (const XrPath path : {XrPath{XR_NULL_PATH}, app.left, app.right, app.Path("/user/gamepad")}) {
      Say("vibrate", app.Vibrate(path, 0.5f));
      const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, path};
      Say("stop", xrStopHapticFeedback(app.session, &info));
      const XrHapticActionInfo wrong{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.select, path};
      Say("stop an input", xrStopHapticFeedback(app.session, &wrong));
    }
  }

  void Sources(App& app) {
    for (const XrAction action : {app.select, app.unbound, app.haptic}) {
      const XrBoundSourcesForActionEnumerateInfo info{XR_TYPE_BOUND_SOURCES_FOR_ACTION_ENUMERATE_INFO, nullptr, action};
      std::uint32_t count = 0;
      XrPath paths[8] = {};
      Say("sources", xrEnumerateBoundSourcesForAction(app.session, &info, 8, &count, paths));
      out_ << count << '\n';
    }
  }

  void Focus(App& app) {
    omni_test_set_focus(0);
    Say("unfocused sync", app.Sync());
    States(app);
    Say("unfocused vibrate", app.Vibrate(app.left, 1));
    omni_test_set_focus(1);
    omni_test_set_bool("/user/hand/left/input/x/click", 1);
    app.Poll();
    Say("focused sync", app.Sync());
    States(app);
    for (const XrStructureType event : app.events) out_ << "event " << event << '\n';
  }

  std::ostringstream out_;
};

// [loader: API Layer Conventions and Rules] the layer must remain compliant, call by call.
TEST(PassThrough, WithoutServiceResultsMatchTheRuntime) {
  const std::string alone = Transcript(false).text();
  const std::string layered = Transcript(true).text();
  EXPECT_GT(std::count(alone.begin(), alone.end(), '\n'), 300);
  std::istringstream a(alone);
  std::istringstream b(layered);
  std::string line_a;
  std::string line_b;
  for (int line = 1; std::getline(a, line_a) && std::getline(b, line_b); ++line)
    ASSERT_EQ(line_a, line_b) << "line " << line;
  EXPECT_EQ(alone, layered);
}

TEST(PassThrough, RuntimeKeepsLeftHandWhilePenOwnsRight) {
  omni_test_reset();
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  omni_test_set_float("/user/hand/left/input/trigger/value", 0.75f);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.left).currentState, 0.75f);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.right).currentState, 0.0f);
  EXPECT_EQ(app.Profile(app.left), kTouch);
  ASSERT_EQ(app.Vibrate(app.left, 0.25f), XR_SUCCESS);
  OmniTestHaptics haptics{};
  omni_test_haptics("left", &haptics);
  EXPECT_EQ(haptics.count, 1u);
  EXPECT_FLOAT_EQ(haptics.last_amplitude, 0.25f);
  EXPECT_TRUE(service.heard().haptics.empty());
}

}  // namespace test_pass_through
}  // namespace omni::test
