// Shared by the tests of action states.
#pragma once

#include <gtest/gtest.h>

#include "tests/layer/support/app.h"

namespace omni::test {

class StatesTest : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
  // One more sync with the pen present.
  static void Step(App& app, FakeService& service) {
    service.Fill();
    ASSERT_EQ(app.Sync(), XR_SUCCESS);
  }
};

inline XrResult AttachSets(const App& app, const std::vector<XrActionSet>& sets) {
  const XrSessionActionSetsAttachInfo info{XR_TYPE_SESSION_ACTION_SETS_ATTACH_INFO, nullptr,
                                           static_cast<std::uint32_t>(sets.size()), sets.data()};
  return xrAttachSessionActionSets(app.session, &info);
}

// Two sets that bind one source, attached.
struct TwoSets {
  TwoSets(App& app, std::uint32_t second_priority) {
    second = app.MakeSet("second", second_priority);
    grab = app.MakeAction(second, "grab", XR_ACTION_TYPE_BOOLEAN_INPUT);
    EXPECT_EQ(app.Suggest(kTouch, {{app.select, "/user/hand/right/input/trigger/value"},
                                   {grab, "/user/hand/right/input/trigger/value"}}),
              XR_SUCCESS);
    EXPECT_EQ(AttachSets(app, {app.set, second}), XR_SUCCESS);
  }
  XrActionSet second = XR_NULL_HANDLE;
  XrAction grab = XR_NULL_HANDLE;
};

}  // namespace omni::test
