// A runtime that is lost, also in the middle of a frame: the application sees what it would see without us, and nothing
// is felt from then on.
#include <gtest/gtest.h>

#include <sstream>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_loss {

using protocol::SessionState;

enum class How { kSession, kInstance, kKilled };
enum class When { kBeforeFrame, kWaited, kBegun, kEnded };

void Lose(How how) {
  if (how == How::kSession) {
    ASSERT_EQ(omni_test_lose_session(), 0);
  } else if (how == How::kInstance) {
    ASSERT_EQ(omni_test_lose_instance(), 0);
  } else {
    ASSERT_EQ(omni_test_kill_runtime(), 0);
  }
}

// Two frames, the loss somewhere in the first, and everything that an application calls in them: names and results.
std::string Frames(App& app, How how, When when) {
  std::ostringstream out;
  const auto say = [&out](const char* call, XrResult result) { out << call << ' ' << Name(result) << '\n'; };
  const auto lose_if = [&](bool now) {
    if (now) Lose(how);
  };
  for (int i = 0; i < 2; ++i) {
    lose_if(i == 0 && when == When::kBeforeFrame);
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
    say("poll", xrPollEvent(app.instance, &event));
    say("sync", app.Sync());
    say("vibrate", app.Vibrate(app.right, 0.5f));
    XrFrameState frame{XR_TYPE_FRAME_STATE};
    say("wait", xrWaitFrame(app.session, nullptr, &frame));
    lose_if(i == 0 && when == When::kWaited);
    say("begin", xrBeginFrame(app.session, nullptr));
    lose_if(i == 0 && when == When::kBegun);
    XrActionStateGetInfo get{XR_TYPE_ACTION_STATE_GET_INFO, nullptr, app.pose, app.right};
    XrActionStatePose pose{XR_TYPE_ACTION_STATE_POSE};
    say("state", xrGetActionStatePose(app.session, &get, &pose));
    const XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO,           nullptr, frame.predictedDisplayTime,
                             XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0,       nullptr};
    say("end", xrEndFrame(app.session, &end));
    lose_if(i == 0 && when == When::kEnded);
  }
  return out.str();
}

class Loss : public testing::TestWithParam<std::tuple<How, When>> {
 protected:
  void SetUp() override { omni_test_reset(); }
};

TEST_P(Loss, IsSeenAsWithoutUsAndNothingIsFelt) {
  const auto [how, when] = GetParam();
  std::string bare;
  {
    AppOptions options;
    options.layer = false;
    App app(options);
    ASSERT_EQ(omni_test_set_device("right", 1, kTouch), 0);
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
    bare = Frames(app, how, when);
  }
  omni_test_reset();
  FakeService service;
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  ASSERT_TRUE(Eventually([&] { return service.heard().last_session() == SessionState::kFocused; }));
  EXPECT_EQ(Frames(app, how, when), bare);
  EXPECT_TRUE(Eventually([&] { return service.heard().last_session() != SessionState::kFocused; }));
}

std::string NameOf(const testing::TestParamInfo<Loss::ParamType>& info) {
  constexpr const char* kHow[] = {"Session", "Instance", "Killed"};
  constexpr const char* kWhen[] = {"BeforeFrame", "Waited", "Begun", "Ended"};
  const auto [how, when] = info.param;
  return std::string(kHow[static_cast<int>(how)]) + kWhen[static_cast<int>(when)];
}

INSTANTIATE_TEST_SUITE_P(Of, Loss,
                         testing::Combine(testing::Values(How::kSession, How::kInstance, How::kKilled),
                                          testing::Values(When::kBeforeFrame, When::kWaited, When::kBegun,
                                                          When::kEnded)),
                         NameOf);

}  // namespace test_loss
}  // namespace omni::test
