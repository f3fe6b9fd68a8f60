// A headset that is taken off: nothing is felt until it is worn again.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/layer/support/app.h"

namespace omni::test {
namespace test_user_presence {

using protocol::SessionState;

class UserPresence : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
  void TearDown() override { ::unsetenv("OMNI_TEST_RUNTIME_WITHOUT"); }
  bool Becomes(App& app, SessionState state) {
    return Eventually([&] {
      app.Poll();
      return service.heard().last_session() == state;
    });
  }
  FakeService service;
};

TEST_F(UserPresence, ForcesEndWhileTheHeadsetIsNotWorn) {
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  ASSERT_TRUE(Becomes(app, SessionState::kFocused));
  ASSERT_EQ(app.Vibrate(app.right, 0.5f), XR_SUCCESS);
  const int stops = service.heard().haptic_stops;
  omni_test_set_user_presence(0);
  EXPECT_TRUE(Becomes(app, SessionState::kBegun)) << "as without focus";
  EXPECT_TRUE(Eventually([&] { return service.heard().haptic_stops > stops; }));
  EXPECT_EQ(app.state, XR_SESSION_STATE_FOCUSED) << "nothing changes for the application";
  EXPECT_EQ(app.Sync(), XR_SUCCESS);
  EXPECT_TRUE(app.PoseActive(app.pose, app.right));

  // A focus that comes and goes meanwhile changes nothing.
  omni_test_set_focus(0);
  app.Poll();
  omni_test_set_focus(1);
  app.Poll();
  EXPECT_EQ(service.heard().last_session(), SessionState::kBegun);

  omni_test_set_user_presence(1);
  EXPECT_TRUE(Becomes(app, SessionState::kFocused));
}

TEST_F(UserPresence, EventIsHiddenFromAnApplicationThatDidNotAskForIt) {
  for (const bool asks : {false, true}) {
    AppOptions options;
    if (asks) options.extensions = {XR_EXT_USER_PRESENCE_EXTENSION_NAME};
    App app(options);
    ASSERT_TRUE(app.WaitProfile(service, kTouch));
    // An event of the application's own behind it is not lost.
    omni_test_set_user_presence(0);
    omni_test_set_user_presence(1);
    omni_test_set_user_presence(0);
    omni_test_set_focus(0);
    app.Poll();
    EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_USER_PRESENCE_CHANGED_EXT), asks ? 4 : 0) << "one at its begin";
    EXPECT_EQ(app.state, XR_SESSION_STATE_VISIBLE);
    EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_EVENTS_LOST), 0);
    omni_test_set_focus(1);
  }
}

TEST_F(UserPresence, RuntimeWithoutItIsNotAskedForIt) {
  ::setenv("OMNI_TEST_RUNTIME_WITHOUT", XR_EXT_USER_PRESENCE_EXTENSION_NAME, 1);
  App app;
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  omni_test_set_user_presence(0);
  app.Poll();
  EXPECT_TRUE(Becomes(app, SessionState::kFocused));
}

}  // namespace test_user_presence
}  // namespace omni::test
