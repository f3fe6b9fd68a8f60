// Ids of render models, when runtime and layer both make them; what applications without the extensions get.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <set>

#include "tests/layer/models/model_app.h"

namespace omni::test {
namespace test_model_ids {

// The first id that the layer makes.
constexpr XrRenderModelIdEXT kLayersFirst = 0x4F4D'4E49'0000'0001;

class ModelIds : public testing::Test {
 protected:
  void SetUp() override { omni_test_reset(); }
  void TearDown() override { omni_test_reset(); }
};

void SetPen(FakeService& service, bool there) {
  service.SetFlags(there ? protocol::kToolPoseValid | protocol::kToolTracked : 0);
}

// A runtime that counts where the layer does, with controllers that come and go, and a pen that does too: at any time
// each id is another model, and an id that is gone never returns.
TEST_F(ModelIds, NeverMeanTwoModels) {
  for (std::uint32_t seed = 0; seed < 12; ++seed) {
    omni_test_reset();
    std::mt19937 random(seed);
    // From as many before the layer's first to a few behind it.
    omni_test_number_models(kLayersFirst - 2 + random() % 6);
    bool left = true, right = true, pen = false;
    FakeService service;
    SetPen(service, pen);
    ModelApp m;
    std::set<XrRenderModelIdEXT> listed, gone;
    for (int step = 0; step < 10; ++step) {
      const std::uint32_t what = random() % 4;
      if (what == 0) left = !left;
      if (what == 1) right = !right;
      if (what >= 2) pen = !pen;
      omni_test_set_device("left", left ? 1 : 0, kSimple);
      omni_test_set_device("right", right ? 1 : 0, kSimple);
      SetPen(service, pen);
      ASSERT_TRUE(m.app.SyncUntil(service, [&] { return (m.app.Profile(m.app.right) == kTouch) == pen; }));
      const std::vector<XrRenderModelIdEXT> ids = m.Ids();
      const std::set<XrRenderModelIdEXT> now(ids.begin(), ids.end());
      EXPECT_EQ(now.size(), ids.size()) << "one id twice: seed " << seed << ", step " << step;
      const int wanted = (left ? 1 : 0) + (pen || right ? 1 : 0);
      EXPECT_EQ(static_cast<int>(ids.size()), wanted) << "seed " << seed << ", step " << step;
      std::set<std::string> hands;
      for (const XrRenderModelIdEXT id : ids) {
        EXPECT_EQ(gone.count(id), 0u) << "seed " << seed << ", step " << step;
        const XrRenderModelEXT model = m.Make(id);
        const std::string hand = m.UserPathOf(model);
        EXPECT_EQ(m.IsPen(model), pen && hand == "/user/hand/right");
        hands.insert(hand);
      }
      EXPECT_EQ(hands.count("/user/hand/left"), left ? 1u : 0u);
      EXPECT_EQ(hands.count("/user/hand/right"), pen || right ? 1u : 0u);
      for (const XrRenderModelIdEXT id : listed) {
        if (now.count(id) != 0) continue;
        gone.insert(id);
        m.Make(id, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT);
      }
      listed = now;
    }
  }
}

// [xrEnumerateInteractionRenderModelIdsEXT] What is enumerated changes in xrSyncActions, and so does the event.
TEST_F(ModelIds, ChangeInSyncOnly) {
  for (const int offered : {1, 0}) {
    omni_test_reset();
    omni_test_offer_models(offered);
    FakeService service;
    ModelApp m;
    ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
    m.TakeChangeEvents();
    const std::vector<XrRenderModelIdEXT> before = m.Ids();
    ASSERT_FALSE(before.empty());
    const XrRenderModelEXT pen = m.Make(before.back());
    ASSERT_TRUE(m.IsPen(pen));
    SetPen(service, false);
    service.Fill();
    EXPECT_EQ(m.TakeChangeEvents(), 0);
    EXPECT_EQ(m.Ids(), before);
    EXPECT_EQ(m.UserPathOf(pen), "/user/hand/right");
    ASSERT_EQ(m.app.Sync(), XR_SUCCESS);
    EXPECT_EQ(m.TakeChangeEvents(), 1);
    EXPECT_EQ(m.Ids().size() + 1, before.size());
    EXPECT_EQ(m.UserPathOf(pen), "");
  }
}

// The other hand's controller is drawn as without the layer.
TEST_F(ModelIds, OtherHandsModelIsTheRuntimes) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  const XrRenderModelEXT left = m.ModelAt("/user/hand/left");
  ASSERT_NE(left, XR_NULL_HANDLE);
  const XrRenderModelPropertiesEXT properties = m.PropertiesOf(left);
  EXPECT_EQ(properties.animatableNodeCount, 1u);
  const XrRenderModelAssetEXT asset = m.AssetOf(properties.cacheId);
  ASSERT_NE(asset, XR_NULL_HANDLE);
  EXPECT_EQ(m.NodesOf(asset, 1), std::vector<std::string>{"trigger"});
  const std::vector<std::uint8_t> bytes = m.BytesOf(asset);
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "glTF");
  EXPECT_NE(bytes.size(), layer::EmbeddedPenModel().bytes.size());
  EXPECT_EQ(m.StateOf(left, 1)[0].isVisible, XR_TRUE);
  EXPECT_EQ(m.destroy_asset(asset), XR_SUCCESS);
  EXPECT_EQ(m.destroy(left), XR_SUCCESS);
  EXPECT_EQ(m.destroy(left), XR_ERROR_HANDLE_INVALID);
}

constexpr const char* kHeldFunctions[] = {"xrEnumerateInteractionRenderModelIdsEXT",
                                          "xrEnumerateRenderModelSubactionPathsEXT",
                                          "xrGetRenderModelPoseTopLevelUserPathEXT"};
constexpr const char* kModelFunctions[] = {
    "xrCreateRenderModelEXT",       "xrDestroyRenderModelEXT",     "xrGetRenderModelPropertiesEXT",
    "xrCreateRenderModelSpaceEXT",  "xrCreateRenderModelAssetEXT", "xrDestroyRenderModelAssetEXT",
    "xrGetRenderModelAssetDataEXT", "xrGetRenderModelStateEXT",    "xrGetRenderModelAssetPropertiesEXT"};

TEST_F(ModelIds, FunctionsNeedTheirExtension) {
  for (const int offered : {1, 0}) {
    omni_test_reset();
    omni_test_offer_models(offered);
    const auto there = [](const App& app, const char* name) {
      return FunctionOf<PFN_xrVoidFunction>(app.instance, name) != nullptr;
    };
    {
      const App app;
      for (const char* name : kModelFunctions) EXPECT_FALSE(there(app, name)) << name;
      for (const char* name : kHeldFunctions) EXPECT_FALSE(there(app, name)) << name;
    }
    AppOptions options;
    options.extensions = {XR_EXT_UUID_EXTENSION_NAME, XR_EXT_RENDER_MODEL_EXTENSION_NAME,
                          XR_EXT_INTERACTION_RENDER_MODEL_EXTENSION_NAME};
    const App app(options);
    for (const char* name : kModelFunctions) EXPECT_TRUE(there(app, name)) << name;
    for (const char* name : kHeldFunctions) EXPECT_TRUE(there(app, name)) << name;
  }
}

// Also where the runtime does not know these names.
TEST_F(ModelIds, EnumerantsHaveNames) {
  omni_test_offer_models(0);
  const App app;
  char text[XR_MAX_STRUCTURE_NAME_SIZE] = {};
  ASSERT_EQ(xrStructureTypeToString(app.instance, XR_TYPE_RENDER_MODEL_STATE_EXT, text), XR_SUCCESS);
  EXPECT_STREQ(text, "XR_TYPE_RENDER_MODEL_STATE_EXT");
  ASSERT_EQ(xrResultToString(app.instance, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT, text), XR_SUCCESS);
  EXPECT_STREQ(text, "XR_ERROR_RENDER_MODEL_ID_INVALID_EXT");
}

}  // namespace test_model_ids
}  // namespace omni::test
