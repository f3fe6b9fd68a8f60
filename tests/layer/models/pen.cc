// The pen's own render model, on runtimes that have render models and on those that have none.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <limits>
#include <random>

#include "layer/src/spaces/locate.h"
#include "tests/layer/models/model_app.h"

namespace omni::test {
namespace test_pen_model {

constexpr auto kPenNodes = static_cast<std::uint32_t>(layer::kPenParts.size());

class PenModel : public testing::TestWithParam<bool> {
 protected:
  void SetUp() override {
    omni_test_reset();
    omni_test_offer_models(GetParam() ? 1 : 0);
  }
  void TearDown() override { omni_test_reset(); }
};
INSTANTIATE_TEST_SUITE_P(Over, PenModel, testing::Bool(),
                         [](const auto& of) { return of.param ? "ModelRuntime" : "BareRuntime"; });

// The whole of the specification's own example: from the id to the bytes, the nodes and the place.
TEST_P(PenModel, ApplicationGetsFileNodesAndPlace) {
  FakeService service;
  ModelApp m;
  EXPECT_TRUE(m.Ids().empty()) << "before the first sync";
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  EXPECT_EQ(m.TakeChangeEvents(), 1);
  EXPECT_EQ(m.TakeChangeEvents(), 0);
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  EXPECT_EQ(m.Ids().size(), GetParam() ? 2u : 1u);
  const XrRenderModelPropertiesEXT properties = m.PropertiesOf(pen);
  EXPECT_EQ(properties.animatableNodeCount, kPenNodes);
  EXPECT_EQ(properties.cacheId.data[6] >> 4, 8) << "version";
  EXPECT_EQ(properties.cacheId.data[8] >> 6, 2) << "variant";
  const XrRenderModelAssetEXT asset = m.AssetOf(properties.cacheId);
  const std::vector<std::uint8_t> bytes = m.BytesOf(asset);
  const auto file = layer::EmbeddedPenModel().bytes;
  EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), file.begin(), file.end()));
  EXPECT_EQ(std::string(bytes.begin(), bytes.begin() + 4), "glTF");
  EXPECT_EQ(m.NodesOf(asset, kPenNodes), (std::vector<std::string>{"tip", "button"}));
  for (const XrRenderModelNodeStateEXT& node : m.StateOf(pen, kPenNodes)) EXPECT_EQ(node.isVisible, XR_TRUE);
  EXPECT_EQ(m.destroy_asset(asset), XR_SUCCESS);
  XrRenderModelAssetDataEXT data{XR_TYPE_RENDER_MODEL_ASSET_DATA_EXT, nullptr, 0, 0, nullptr};
  EXPECT_EQ(m.asset_data(asset, nullptr, &data), XR_ERROR_HANDLE_INVALID);
  service.Fill();
  EXPECT_TRUE(m.Shown(m.SpaceOf(pen)));
  EXPECT_TRUE(m.IsPen(m.Make(m.Ids().back()))) << "a second handle of the same id";
}

TEST_P(PenModel, BytesFollowTheTwoCallIdiom) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  const XrRenderModelAssetEXT asset = m.AssetOf(m.PropertiesOf(pen).cacheId);
  const auto all = static_cast<std::uint32_t>(m.BytesOf(asset).size());
  std::vector<std::uint8_t> room(all + 1, 0xAB);
  XrRenderModelAssetDataEXT data{XR_TYPE_RENDER_MODEL_ASSET_DATA_EXT, nullptr, all - 1, 0, room.data()};
  EXPECT_EQ(m.asset_data(asset, nullptr, &data), XR_ERROR_SIZE_INSUFFICIENT);
  EXPECT_EQ(data.bufferCountOutput, all);
  EXPECT_EQ(room, std::vector<std::uint8_t>(all + 1, 0xAB));
  data.bufferCapacityInput = all + 1;
  EXPECT_EQ(m.asset_data(asset, nullptr, &data), XR_SUCCESS);
  EXPECT_EQ(data.bufferCountOutput, all);
  EXPECT_EQ(room.back(), 0xAB);
  data.buffer = nullptr;
  EXPECT_EQ(m.asset_data(asset, nullptr, &data), XR_ERROR_VALIDATION_FAILURE);
  data.type = XR_TYPE_RENDER_MODEL_STATE_EXT;
  EXPECT_EQ(m.asset_data(asset, nullptr, &data), XR_ERROR_VALIDATION_FAILURE);
  std::uint32_t count = 0;
  XrRenderModelIdEXT id = 0;
  EXPECT_EQ(m.enumerate(m.app.session, nullptr, 0, nullptr, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(m.enumerate(m.app.session, nullptr, 9, &count, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(m.enumerate(m.app.session, nullptr, 1, &count, &id), GetParam() ? XR_ERROR_SIZE_INSUFFICIENT : XR_SUCCESS);
}

// Tip and button follow the inputs of the service, whatever they are.
TEST_P(PenModel, PartsMoveWithTheInputs) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  std::mt19937 random(7);
  std::uniform_real_distribution<float> any(-0.2f, 1.2f);
  using protocol::InputIndex;
  for (int i = 0; i < 50; ++i) {
    const float tip = any(random), secondary = any(random), menu = any(random);
    service.Set(InputIndex::kTipForce, tip);
    service.Set(InputIndex::kSecondary, secondary);
    service.Set(InputIndex::kMenu, menu);
    service.Fill();
    const auto nodes = m.StateOf(pen, kPenNodes);
    const float button = std::clamp(std::max(secondary, menu), 0.0f, 1.0f);
    EXPECT_FLOAT_EQ(nodes[0].nodePose.position.z, 0.001f * std::clamp(tip, 0.0f, 1.0f));
    EXPECT_EQ(nodes[0].nodePose.position.x, 0);
    EXPECT_EQ(nodes[0].nodePose.position.y, 0);
    EXPECT_FLOAT_EQ(nodes[1].nodePose.position.y, -0.0008f * button);
    EXPECT_EQ(nodes[1].nodePose.position.x, 0);
    EXPECT_EQ(nodes[1].nodePose.position.z, 0);
    for (const XrRenderModelNodeStateEXT& node : nodes) {
      EXPECT_EQ(node.nodePose.orientation.w, 1);
      EXPECT_EQ(node.isVisible, XR_TRUE);
    }
  }
  service.Set(InputIndex::kTipForce, std::numeric_limits<float>::quiet_NaN());
  service.Fill();
  EXPECT_EQ(m.StateOf(pen, kPenNodes)[0].nodePose.position.z, 0) << "a force that is no number";
}

// Origin at the tip: where the aim pose of the same hand is.
TEST_P(PenModel, OriginIsTheTip) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  const XrSpace model = m.SpaceOf(pen);
  const XrSpace aim = m.app.ActionSpace(m.app.pose, m.app.right);
  service.Fill();
  ASSERT_EQ(m.app.Sync(), XR_SUCCESS);
  const XrTime now = Now_ns() + kRuntimeOffset_ns;
  XrSpaceLocation in_aim{XR_TYPE_SPACE_LOCATION}, in_local{XR_TYPE_SPACE_LOCATION},
      aim_in_local{XR_TYPE_SPACE_LOCATION};
  ASSERT_EQ(xrLocateSpace(model, aim, now, &in_aim), XR_SUCCESS);
  ASSERT_EQ(xrLocateSpace(model, m.local, now, &in_local), XR_SUCCESS);
  ASSERT_EQ(xrLocateSpace(aim, m.local, now, &aim_in_local), XR_SUCCESS);
  const XrSpaceLocationFlags all = layer::kValid | layer::kTracked;
  EXPECT_EQ(in_aim.locationFlags, all);
  EXPECT_EQ(in_local.locationFlags, all);
  const layer::Pose pose = layer::FromXr(in_aim.pose);
  EXPECT_LT(glm::length(pose.p), 1e-7);
  EXPECT_NEAR(std::abs(pose.q.w), 1, 1e-7);
  EXPECT_LT(glm::length(layer::FromXr(in_local.pose).p - layer::FromXr(aim_in_local.pose).p), 1e-7);
  EXPECT_EQ(xrDestroySpace(model), XR_SUCCESS);
  EXPECT_EQ(xrLocateSpace(model, m.local, now, &in_local), XR_ERROR_HANDLE_INVALID);
}

TEST_P(PenModel, NotLocatableWithoutFocusAndWithoutItsModel) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  const XrSpace space = m.SpaceOf(pen);
  service.Fill();
  EXPECT_TRUE(m.Shown(space));
  omni_test_set_focus(0);
  EXPECT_EQ(m.app.Sync(), XR_SESSION_NOT_FOCUSED);
  EXPECT_FALSE(m.Shown(space)) << "rendered twice otherwise";
  omni_test_set_focus(1);
  m.app.PollUntilFocused();
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  service.Fill();
  EXPECT_TRUE(m.Shown(space));
  EXPECT_EQ(m.destroy(pen), XR_SUCCESS);
  EXPECT_FALSE(m.Shown(space));
  EXPECT_EQ(m.destroy(pen), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(xrDestroySpace(space), XR_SUCCESS);
}

// The subaction path is there while an action that declares it is bound to the pen in a set of the last sync.
TEST_P(PenModel, SubactionPathFollowsTheActiveSets) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  const auto paths = [&] {
    std::uint32_t count = 7;
    XrPath path = XR_NULL_PATH;
    EXPECT_EQ(m.subactions(pen, nullptr, 1, &count, &path), XR_SUCCESS);
    return count == 0 ? std::string() : m.app.Text(path);
  };
  EXPECT_EQ(paths(), "/user/hand/right");
  service.Fill();
  ASSERT_EQ(m.app.SyncSets({}), XR_SUCCESS);
  EXPECT_EQ(paths(), "");
  EXPECT_EQ(m.UserPathOf(pen), "/user/hand/right") << "which does not depend on actions";
  service.Fill();
  ASSERT_EQ(m.app.SyncSets({{m.app.set, m.app.left}}), XR_SUCCESS);
  EXPECT_EQ(paths(), "");
  service.Fill();
  ASSERT_EQ(m.app.SyncSets({{m.app.set, m.app.right}}), XR_SUCCESS);
  EXPECT_EQ(paths(), "/user/hand/right");
}

// Arguments that the specification names an error for.
TEST_P(PenModel, WrongArgumentsAreRejected) {
  FakeService service;
  ModelApp m;
  // A hand that has no model, before anything is held.
  m.Make(XR_NULL_RENDER_MODEL_ID_EXT, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT);
  m.Make(0x4F4D'4E49'0000'0001, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT);
  m.AssetOf(layer::EmbeddedPenModel().id, XR_ERROR_RENDER_MODEL_ASSET_UNAVAILABLE_EXT);
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  m.Make(XR_NULL_RENDER_MODEL_ID_EXT, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT);
  m.Make(123456, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT);
  ASSERT_FALSE(m.Ids().empty());
  const XrRenderModelIdEXT id = m.Ids().back();
  XrRenderModelEXT made = XR_NULL_HANDLE;
  XrRenderModelCreateInfoEXT create{XR_TYPE_RENDER_MODEL_CREATE_INFO_EXT, nullptr, id, 0, nullptr};
  EXPECT_EQ(m.create(m.app.session, &create, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(m.create(m.app.session, nullptr, &made), XR_ERROR_VALIDATION_FAILURE);
  create.type = XR_TYPE_RENDER_MODEL_STATE_EXT;
  EXPECT_EQ(m.create(m.app.session, &create, &made), XR_ERROR_VALIDATION_FAILURE);
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  m.AssetOf(m.PropertiesOf(pen).cacheId);
  XrUuidEXT other = layer::EmbeddedPenModel().id;
  other.data[15] ^= 1;
  m.AssetOf(other, XR_ERROR_RENDER_MODEL_ASSET_UNAVAILABLE_EXT);

  XrRenderModelPropertiesEXT properties{XR_TYPE_RENDER_MODEL_STATE_EXT, nullptr, {}, 0};
  EXPECT_EQ(m.properties(pen, nullptr, &properties), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(m.properties(pen, nullptr, nullptr), XR_ERROR_VALIDATION_FAILURE);
  properties.type = XR_TYPE_RENDER_MODEL_PROPERTIES_EXT;
  EXPECT_EQ(m.properties(XR_NULL_HANDLE, nullptr, &properties), XR_ERROR_HANDLE_INVALID);

  std::vector<XrRenderModelNodeStateEXT> nodes(kPenNodes + 1);
  XrRenderModelStateGetInfoEXT when{XR_TYPE_RENDER_MODEL_STATE_GET_INFO_EXT, nullptr, 1};
  XrRenderModelStateEXT state{XR_TYPE_RENDER_MODEL_STATE_EXT, nullptr, kPenNodes, nodes.data()};
  EXPECT_EQ(m.state(pen, &when, &state), XR_SUCCESS);
  EXPECT_EQ(m.state(pen, nullptr, &state), XR_ERROR_VALIDATION_FAILURE);
  for (const std::uint32_t count : {0u, kPenNodes - 1, kPenNodes + 1}) {
    state.nodeStateCount = count;
    EXPECT_EQ(m.state(pen, &when, &state), XR_ERROR_VALIDATION_FAILURE) << count;
  }
  state = {XR_TYPE_RENDER_MODEL_STATE_EXT, nullptr, kPenNodes, nullptr};
  EXPECT_EQ(m.state(pen, &when, &state), XR_ERROR_VALIDATION_FAILURE);
  state.nodeStates = nodes.data();
  when.displayTime = 0;
  EXPECT_EQ(m.state(pen, &when, &state), XR_ERROR_TIME_INVALID);

  const XrRenderModelAssetEXT asset = m.AssetOf(layer::EmbeddedPenModel().id);
  std::vector<XrRenderModelAssetNodePropertiesEXT> names(kPenNodes + 1);
  XrRenderModelAssetPropertiesEXT listed{XR_TYPE_RENDER_MODEL_ASSET_PROPERTIES_EXT, nullptr, 0, nullptr};
  EXPECT_EQ(m.asset_properties(asset, nullptr, &listed), XR_ERROR_VALIDATION_FAILURE);
  listed = {XR_TYPE_RENDER_MODEL_ASSET_PROPERTIES_EXT, nullptr, kPenNodes + 1, names.data()};
  EXPECT_EQ(m.asset_properties(asset, nullptr, &listed), XR_ERROR_VALIDATION_FAILURE);

  XrSpace space = XR_NULL_HANDLE;
  const XrRenderModelSpaceCreateInfoEXT nowhere{XR_TYPE_RENDER_MODEL_SPACE_CREATE_INFO_EXT, nullptr, XR_NULL_HANDLE};
  EXPECT_EQ(m.create_space(m.app.session, &nowhere, &space), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(m.create_space(m.app.session, nullptr, &space), XR_ERROR_VALIDATION_FAILURE);
}

TEST_P(PenModel, UserPathQueriesAreChecked) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  const auto ask = [&](const std::vector<XrPath>& paths, XrPath& path) {
    const XrInteractionRenderModelTopLevelUserPathGetInfoEXT info{
        XR_TYPE_INTERACTION_RENDER_MODEL_TOP_LEVEL_USER_PATH_GET_INFO_EXT, nullptr,
        static_cast<std::uint32_t>(paths.size()), paths.data()};
    return m.user_path(pen, &info, &path);
  };
  XrPath path = XR_NULL_PATH;
  EXPECT_EQ(ask({m.app.left, m.app.right}, path), XR_SUCCESS);
  EXPECT_EQ(path, m.app.right);
  EXPECT_EQ(ask({m.app.left, m.app.Path("/user/head")}, path), XR_SUCCESS);
  EXPECT_EQ(path, XR_NULL_PATH) << "not in the list";
  EXPECT_EQ(ask({}, path), XR_SUCCESS);
  EXPECT_EQ(path, XR_NULL_PATH);
  EXPECT_EQ(ask({m.app.right, m.app.left, m.app.right}, path), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(ask({m.app.right, XR_NULL_PATH}, path), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(ask({m.app.right, XrPath{987654321}}, path), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(ask({m.app.Path("/user/hand/right/input/a/click")}, path), XR_ERROR_PATH_INVALID);
  EXPECT_EQ(m.user_path(pen, nullptr, &path), XR_ERROR_VALIDATION_FAILURE);
}

TEST_P(PenModel, EnumerationNeedsARunningSession) {
  AppOptions options = ModelApp::Options();
  options.begin = false;
  const App app(options);
  const auto enumerate =
      FunctionOf<PFN_xrEnumerateInteractionRenderModelIdsEXT>(app.instance, "xrEnumerateInteractionRenderModelIdsEXT");
  ASSERT_NE(enumerate, nullptr);
  std::uint32_t count = 0;
  EXPECT_EQ(enumerate(app.session, nullptr, 0, &count, nullptr), XR_ERROR_SESSION_NOT_RUNNING);
  EXPECT_EQ(enumerate(XR_NULL_HANDLE, nullptr, 0, &count, nullptr), XR_ERROR_HANDLE_INVALID);
}

// Ids and handles are the session's; what a session has not been given, it cannot make.
TEST_P(PenModel, NothingOutlivesItsSession) {
  FakeService service;
  ModelApp m;
  ASSERT_TRUE(m.app.WaitProfile(service, kTouch));
  ASSERT_FALSE(m.Ids().empty());
  const XrRenderModelIdEXT id = m.Ids().back();
  const XrRenderModelEXT pen = m.ModelAt("/user/hand/right");
  ASSERT_NE(pen, XR_NULL_HANDLE);
  const XrRenderModelAssetEXT asset = m.AssetOf(m.PropertiesOf(pen).cacheId);
  ASSERT_EQ(xrDestroySession(m.app.session), XR_SUCCESS);
  XrRenderModelPropertiesEXT properties{XR_TYPE_RENDER_MODEL_PROPERTIES_EXT, nullptr, {}, 0};
  EXPECT_EQ(m.properties(pen, nullptr, &properties), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(m.destroy_asset(asset), XR_ERROR_HANDLE_INVALID);
  m.app.state = XR_SESSION_STATE_UNKNOWN;
  const XrSessionCreateInfo info{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, m.app.system};
  ASSERT_EQ(xrCreateSession(m.app.instance, &info, &m.app.session), XR_SUCCESS);
  m.AssetOf(layer::EmbeddedPenModel().id, XR_ERROR_RENDER_MODEL_ASSET_UNAVAILABLE_EXT);
  m.Make(id, XR_ERROR_RENDER_MODEL_ID_INVALID_EXT);
}

}  // namespace test_pen_model
}  // namespace omni::test
