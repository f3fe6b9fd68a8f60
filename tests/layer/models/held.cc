// What an application draws in a hand: the runtime's controller, or the pen while it owns the hand.
#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "tests/layer/models/model_app.h"

namespace omni::test {
namespace test_models {

class Models : public testing::Test {
 protected:
  void SetUp() override {
    omni_test_reset();
    omni_test_set_device("left", 1, kSimple);
    omni_test_set_device("right", 1, kSimple);
  }
};

// Whoever holds a hand in turn, for either hand: controller, pen, controller, pen.
TEST_F(Models, InteractionModelsAreOfWhoHoldsTheHand) {
  for (const std::string side : {"right", "left"}) {
    SetUp();
    ModelApp m;
    const XrPath hand = side == "left" ? m.app.left : m.app.right;
    const std::string user = "/user/hand/" + side, other = side == "left" ? "/user/hand/right" : "/user/hand/left";
    EXPECT_TRUE(m.Ids().empty()) << "before the first sync";
    ASSERT_EQ(m.app.Sync(), XR_SUCCESS);
    EXPECT_EQ(m.TakeChangeEvents(), 1);
    EXPECT_EQ(m.Ids().size(), 2u);
    std::vector<XrRenderModelIdEXT> enumerated = m.Ids();
    XrRenderModelEXT model = m.ModelAt(user);
    ASSERT_NE(model, XR_NULL_HANDLE);
    XrSpace space = m.SpaceOf(model);
    const XrSpace others = m.SpaceOf(m.ModelAt(other));
    EXPECT_TRUE(m.Shown(space));

    FakeService service;
    protocol::AppSettings settings;
    settings.hand = side == "left" ? protocol::HandSetting::kLeft : protocol::HandSetting::kRight;
    service.Wish(settings);
    for (int visit = 0; visit < 2; ++visit) {
      service.SetFlags(protocol::kToolPoseValid | protocol::kToolTracked);
      ASSERT_TRUE(m.Until(service, hand, kTouch));
      EXPECT_EQ(m.TakeChangeEvents(), 1) << "of one sync";
      const std::vector<XrRenderModelIdEXT> during = m.Ids();
      EXPECT_EQ(during.size(), 2u);
      const XrRenderModelEXT pen = m.ModelAt(user);
      ASSERT_NE(pen, XR_NULL_HANDLE);
      EXPECT_TRUE(m.IsPen(pen));
      const XrSpace pens = m.SpaceOf(pen);
      service.Fill();
      EXPECT_TRUE(m.Shown(pens));
      ASSERT_NE(m.ModelAt(other), XR_NULL_HANDLE);
      EXPECT_FALSE(m.IsPen(m.ModelAt(other)));
      // What was made of the controller's id is never shown again, and cannot be made again.
      EXPECT_FALSE(m.Shown(space));
      EXPECT_FALSE(m.Shown(m.SpaceOf(model)));
      EXPECT_EQ(m.UserPathOf(model), "");
      std::uint32_t paths = 9;
      EXPECT_EQ(m.subactions(model, nullptr, 0, &paths, nullptr), XR_SUCCESS);
      EXPECT_EQ(paths, 0u);
      for (const XrRenderModelIdEXT id : enumerated) {
        const bool listed = std::find(during.begin(), during.end(), id) != during.end();
        if (!listed) m.Make(id, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT);
      }
      for (const XrRenderModelIdEXT id : during) {
        const bool was = std::find(enumerated.begin(), enumerated.end(), id) != enumerated.end();
        EXPECT_EQ(was, m.UserPathOf(m.Make(id)) == other) << "a pen that returns has a new id";
        if (!was) enumerated.push_back(id);
      }
      EXPECT_TRUE(m.Shown(others));
      service.Fill();
      ASSERT_EQ(m.app.Sync(), XR_SUCCESS);
      EXPECT_EQ(m.TakeChangeEvents(), 0) << "nothing has changed";

      service.SetFlags(0);
      ASSERT_TRUE(m.Until(service, hand, kSimple));
      EXPECT_EQ(m.TakeChangeEvents(), 1);
      const std::vector<XrRenderModelIdEXT> after = m.Ids();
      EXPECT_EQ(after.size(), 2u);
      const XrRenderModelEXT again = m.ModelAt(user);
      ASSERT_NE(again, XR_NULL_HANDLE);
      for (const XrRenderModelIdEXT id : after) {
        const bool was = std::find(enumerated.begin(), enumerated.end(), id) != enumerated.end();
        EXPECT_EQ(was, m.UserPathOf(m.Make(id)) == other) << "a device that returns has a new id";
        if (!was) enumerated.push_back(id);
      }
      EXPECT_FALSE(m.IsPen(again));
      EXPECT_FALSE(m.Shown(pens));
      EXPECT_EQ(m.UserPathOf(pen), "");
      EXPECT_FALSE(m.Shown(space));
      space = m.SpaceOf(again);
      EXPECT_TRUE(m.Shown(space));
      EXPECT_EQ(m.destroy(model), XR_SUCCESS);
      model = again;
    }
    EXPECT_TRUE(m.Shown(others));
  }
}

TEST_F(Models, HandSwitchMovesThePensModel) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.Until(service, m.app.right, kTouch));
  EXPECT_FALSE(m.IsPen(m.ModelAt("/user/hand/left")));
  EXPECT_TRUE(m.IsPen(m.ModelAt("/user/hand/right")));
  protocol::AppSettings settings;
  settings.hand = protocol::HandSetting::kLeft;
  service.Wish(settings);
  m.TakeChangeEvents();
  ASSERT_TRUE(m.Until(service, m.app.left, kTouch));
  EXPECT_EQ(m.TakeChangeEvents(), 1) << "the controllers of both hands";
  EXPECT_TRUE(m.IsPen(m.ModelAt("/user/hand/left")));
  EXPECT_FALSE(m.IsPen(m.ModelAt("/user/hand/right")));
  omni_test_set_device("left", 0, nullptr);
  omni_test_set_device("right", 0, nullptr);
  service.Fill();
  ASSERT_EQ(m.app.Sync(), XR_SUCCESS);
  ASSERT_EQ(m.Ids().size(), 1u);
  EXPECT_TRUE(m.IsPen(m.Make(m.Ids()[0])));
}

// A second session starts as the first one did.
TEST_F(Models, SecondSessionEnumeratesItsOwnModels) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.Until(service, m.app.right, kTouch));
  EXPECT_EQ(m.Ids().size(), 2u);
  ASSERT_EQ(xrDestroySession(m.app.session), XR_SUCCESS);
  service.SetFlags(0);
  service.Fill();
  m.app.state = XR_SESSION_STATE_UNKNOWN;
  const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, m.app.system};
  ASSERT_EQ(xrCreateSession(m.app.instance, &info, &m.app.session), XR_SUCCESS);
  ASSERT_EQ(m.app.Attach(), XR_SUCCESS);
  m.app.PollUntilFocused();
  ASSERT_TRUE(m.Until(service, m.app.right, kSimple));
  EXPECT_EQ(m.Ids().size(), 2u);
}

TEST_F(Models, OlderExtensionsHaveNoModelForThePensHand) {
  ModelApp m;
  ASSERT_EQ(m.app.Sync(), XR_SUCCESS);
  const XrControllerModelKeyMSFT controller = m.Key(m.app.right);
  EXPECT_NE(controller, XR_NULL_CONTROLLER_MODEL_KEY_MSFT);
  const std::vector<std::string> both{"/model_fb/controller/left", "/model_fb/controller/right"};
  EXPECT_EQ(m.PathsFB(), both);
  const auto properties = [&](const char* path) {
    XrRenderModelPropertiesFB out{XR_TYPE_RENDER_MODEL_PROPERTIES_FB};
    const XrResult result = m.properties_fb(m.app.session, m.app.Path(path), &out);
    EXPECT_EQ(out.modelKey != 0, result == XR_SUCCESS);
    return result;
  };
  FakeService service;
  for (int visit = 0; visit < 2; ++visit) {
    service.SetFlags(protocol::kToolPoseValid | protocol::kToolTracked);
    ASSERT_TRUE(m.Until(service, m.app.right, kTouch));
    EXPECT_EQ(m.Key(m.app.right), XR_NULL_CONTROLLER_MODEL_KEY_MSFT);
    EXPECT_NE(m.Key(m.app.left), XR_NULL_CONTROLLER_MODEL_KEY_MSFT);
    EXPECT_EQ(m.PathsFB(), std::vector<std::string>{both[0]});
    std::uint32_t count = 0;
    XrRenderModelPathInfoFB one{XR_TYPE_RENDER_MODEL_PATH_INFO_FB};
    EXPECT_EQ(m.paths_fb(m.app.session, 1, &count, &one), XR_SUCCESS);
    EXPECT_EQ(properties("/model_fb/controller/left"), XR_SUCCESS);
    EXPECT_EQ(properties("/model_fb/controller/right"), XR_RENDER_MODEL_UNAVAILABLE_FB);
    EXPECT_EQ(properties("/model_fb/keyboard/local"), XR_ERROR_PATH_INVALID) << "the runtime's own answer";
    service.SetFlags(0);
    ASSERT_TRUE(m.Until(service, m.app.right, kSimple));
    EXPECT_EQ(m.Key(m.app.right), controller);
    EXPECT_EQ(m.PathsFB(), both);
    EXPECT_EQ(m.paths_fb(m.app.session, 1, &count, &one), XR_ERROR_SIZE_INSUFFICIENT);
    EXPECT_EQ(properties("/model_fb/controller/right"), XR_SUCCESS);
  }
}

// The pen gives its hand back in the sync in which the other controller goes off.
TEST_F(Models, ChangesOfPenAndRuntimeAreOneEvent) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.Until(service, m.app.right, kTouch));
  m.TakeChangeEvents();
  omni_test_set_device("left", 0, nullptr);
  service.SetFlags(0);
  ASSERT_TRUE(m.Until(service, m.app.right, kSimple));
  EXPECT_EQ(m.TakeChangeEvents(), 1);
  EXPECT_EQ(m.Ids().size(), 1u);
}

// Without the extension there is no event of it, and without a service all is the runtime's.
TEST_F(Models, ApplicationsWithoutTheExtensionGetNoEvent) {
  FakeService service;
  AppOptions options;
  options.profiles = {kTouch, kSimple};
  App app(options);
  EXPECT_EQ(FunctionOf<PFN_xrCreateRenderModelEXT>(app.instance, "xrCreateRenderModelEXT"), nullptr);
  ASSERT_TRUE(app.WaitProfile(service, kTouch));
  app.Poll();
  EXPECT_EQ(app.CountEvents(XR_TYPE_EVENT_DATA_INTERACTION_RENDER_MODELS_CHANGED_EXT), 0);
}

}  // namespace test_models
}  // namespace omni::test
