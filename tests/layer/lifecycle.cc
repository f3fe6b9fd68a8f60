// Sessions, haptics and heartbeats as the service receives them; repeated instances.
#include <gtest/gtest.h>

#include <filesystem>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_lifecycle {

using protocol::SessionState;

class Lifecycle : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
  static bool Until(const std::function<bool()>& done) { return Eventually(done); }
};

TEST_F(Lifecycle, ServiceReceivesApplicationNameAndSessionStates) {
  FakeService service;
  {
    AppOptions options;
    options.name = "Caf\xC3\xA9 demo";
    App app(options);
    ASSERT_TRUE(app.WaitProfile(service, kTouch));
    ASSERT_TRUE(Until([&] { return !service.heard().sessions.empty(); }));
    EXPECT_EQ(service.heard().applications, std::vector<std::string>{"Caf\xC3\xA9 demo"});
    EXPECT_TRUE(Until([&] { return service.heard().last_session() == SessionState::kFocused; }));

    omni_test_set_focus(0);
    ASSERT_EQ(app.Sync(), XR_SESSION_NOT_FOCUSED);
    EXPECT_TRUE(Until([&] { return service.heard().last_session() == SessionState::kBegun; }))
        << "reported by the sync";
    omni_test_set_focus(1);
    app.Poll();
    EXPECT_TRUE(Until([&] { return service.heard().last_session() == SessionState::kFocused; }))
        << "reported by the event";

    ASSERT_EQ(xrRequestExitSession(app.session), XR_SUCCESS);
    ASSERT_TRUE(Until([&] {
      app.Poll();
      return app.state == XR_SESSION_STATE_IDLE || app.state == XR_SESSION_STATE_EXITING;
    }));
    EXPECT_TRUE(Until([&] { return service.heard().last_session() == SessionState::kNone; })) << "session ended";
  }
  EXPECT_TRUE(Until([&] { return service.heard().gone == 1; })) << "instance destroyed";
}

TEST_F(Lifecycle, DestroyedSessionIsReportedAsEnded) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  ASSERT_TRUE(Until([&] { return service.heard().last_session() == SessionState::kFocused; }));
  ASSERT_EQ(xrDestroySession(app.session), XR_SUCCESS);
  EXPECT_TRUE(Until([&] { return service.heard().last_session() == SessionState::kNone; }));
}

// Every intercepted call updates the heartbeat.
TEST_F(Lifecycle, InterceptedCallsUpdateTheHeartbeat) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  const XrSpace local = app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  const timespec pause{0, 100'000'000};
  nanosleep(&pause, nullptr);
  const std::uint64_t before = service.beats();
  XrSpaceLocation location{XR_TYPE_SPACE_LOCATION};
  ASSERT_EQ(xrLocateSpace(local, local, Now_ns() + kRuntimeOffset_ns, &location), XR_SUCCESS);
  EXPECT_TRUE(Until([&] { return service.beats() > before; }));
}

// [input-output-actions-haptics]
TEST_F(Lifecycle, HapticsReachTheService) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  ASSERT_EQ(app.Vibrate(app.right, 0.5f), XR_SUCCESS);
  ASSERT_TRUE(Until([&] { return service.heard().haptics.size() == 1; })) << "at once, not at the sync";
  const protocol::Haptic haptic = service.heard().haptics[0];
  EXPECT_EQ(haptic.duration_ns, 20'000'000);
  EXPECT_FLOAT_EQ(haptic.amplitude, 0.5f);
  EXPECT_FLOAT_EQ(haptic.frequency_Hz, 150.0f);

  ASSERT_EQ(app.Vibrate(XR_NULL_PATH, 1.0f), XR_SUCCESS);
  ASSERT_TRUE(Until([&] { return service.heard().haptics.size() == 2; })) << "no subaction path: all devices";
  EXPECT_FLOAT_EQ(service.heard().haptics[1].amplitude, 1.0f);
  OmniTestHaptics left{};
  omni_test_haptics("left", &left);
  EXPECT_EQ(left.count, 1u);

  const XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, app.right};
  ASSERT_EQ(xrStopHapticFeedback(app.session, &info), XR_SUCCESS);
  EXPECT_TRUE(Until([&] { return service.heard().haptic_stops == 1; }));
}

TEST_F(Lifecycle, HapticsValidateArgumentsAndNeedFocus) {
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  XrHapticVibration vibration{XR_TYPE_HAPTIC_VIBRATION, nullptr, XR_MIN_HAPTIC_DURATION, 0, 1};
  const auto* header = static_cast<const XrHapticBaseHeader*>(static_cast<const void*>(&vibration));
  XrHapticActionInfo info{XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.select, app.right};
  EXPECT_EQ(xrApplyHapticFeedback(app.session, &info, header), XR_ERROR_ACTION_TYPE_MISMATCH);
  info = {XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, app.Path("/user/gamepad")};
  EXPECT_EQ(xrApplyHapticFeedback(app.session, &info, header), XR_ERROR_PATH_UNSUPPORTED);
  EXPECT_EQ(xrApplyHapticFeedback(app.session, nullptr, header), XR_ERROR_VALIDATION_FAILURE);
  info = {XR_TYPE_HAPTIC_ACTION_INFO, nullptr, app.haptic, app.right};
  EXPECT_EQ(xrApplyHapticFeedback(app.session, &info, nullptr), XR_ERROR_VALIDATION_FAILURE);
  ASSERT_EQ(app.Vibrate(app.right, 1), XR_SUCCESS);
  omni_test_set_focus(0);
  ASSERT_EQ(app.Sync(), XR_SESSION_NOT_FOCUSED);
  EXPECT_TRUE(Until([&] { return service.heard().haptic_stops == 1; })) << "vibrations stop when focus is lost";
  EXPECT_EQ(app.Vibrate(app.right, 1), XR_SESSION_NOT_FOCUSED);
  const timespec pause{0, 30'000'000};
  nanosleep(&pause, nullptr);
  EXPECT_EQ(service.heard().haptics.size(), 1u);
}

// kill -9 of the service and its return, without a restart of the application.
TEST_F(Lifecycle, ReconnectsToRestartedService) {
  App app;
  for (int life = 0; life < 3; ++life) {
    FakeService service;
    ASSERT_TRUE(app.SyncUntil(service, [&] { return !service.heard().sessions.empty(); })) << "life " << life;
    EXPECT_EQ(service.heard().last_session(), SessionState::kFocused) << "sent again after each restart";
    ASSERT_TRUE(app.WaitProfile(service, kTouch));
  }
  ASSERT_TRUE(Until([&] {
    EXPECT_EQ(app.Sync(), XR_SUCCESS);
    return app.Profile(app.right).empty();
  }));
  EXPECT_FALSE(app.PoseActive(app.pose, app.right));
}

// Applications create and destroy instances again and again.
TEST_F(Lifecycle, FiftyInstancesLeakNoHandlesOrFiles) {
  FakeService service;
  const auto open_files = [] {
    const std::filesystem::directory_iterator files("/proc/self/fd");
    return std::distance(begin(files), end(files));
  };
  const auto before = open_files();
  for (int i = 0; i < 50; ++i) {
    const App app;
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
  }
  EXPECT_EQ(omni_test_live_handles(), 0u);
  EXPECT_TRUE(Until([&] { return open_files() == before; })) << "every connection is closed, on both sides";
  App last;
  EXPECT_TRUE(last.WaitProfile(service, kTouch));
}

TEST_F(Lifecycle, EnvironmentSelectsLeftHand) {
  setenv("OMNI_HAND", "left", 1);
  omni_test_set_device("left", 0, nullptr);
  omni_test_set_device("right", 1, kTouch);
  FakeService service;
  App app;
  unsetenv("OMNI_HAND");
  EXPECT_TRUE(app.SyncUntil(service, [&] { return app.Profile(app.left) == kTouch; }));
  service.Set(protocol::InputIndex::kTipForce, 0.5f);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_FLOAT_EQ(app.Float(app.force, app.left).currentState, 0.5f);
}

// Without XR_KHR_convert_timespec_time in the application's list the layer still enables it, and hides it.
TEST_F(Lifecycle, TimeConversionExtensionIsHiddenFromApplication) {
  FakeService service;
  AppOptions options;
  options.timespec_extension = false;
  App app(options);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  PFN_xrVoidFunction function = nullptr;
  EXPECT_EQ(xrGetInstanceProcAddr(app.instance, "xrConvertTimespecTimeToTimeKHR", &function),
            XR_ERROR_FUNCTION_UNSUPPORTED);
  service.Set(protocol::InputIndex::kSelect, 1);
  service.Fill();
  ASSERT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_NEAR(static_cast<double>(app.Bool(app.select, app.right).lastChangeTime),
              static_cast<double>(Now_ns() + kRuntimeOffset_ns), 1e9);
}

}  // namespace test_lifecycle
}  // namespace omni::test
