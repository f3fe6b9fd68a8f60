// Rules of docs/extensions/XR_OMNIX1_haptic_scene.md: which calls are valid when, limits, moving spaces, and events.
#include <cmath>
#include <cstdint>

#include "layer/src/spaces/locate.h"
#include "tests/layer/support/scene_scenario.h"

namespace omni::test {
namespace test_haptic_scene_rules {

constexpr XrPosef kHere{{0, 0, 0, 1}, {0, 0, 0}};

// The results of everything that needs more than a handle, in one order.
std::vector<XrResult> AskAll(const SceneScenario& scenario, XrHapticNodeIdOMNIX1 node) {
  const XrTime now = Now_ns() + kRuntimeOffset_ns;
  const XrSpace local = scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  std::uint32_t count = 0;
  XrHapticMaterialOMNIX1 material{XR_TYPE_HAPTIC_MATERIAL_OMNIX1};
  const XrHapticNodePoseOMNIX1 pose{node, 0, kHere, {0, 0, 0}, {0, 0, 0}};
  const XrHapticNodesUpdateInfoOMNIX1 update{
      XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1, nullptr, XR_NULL_HANDLE, now, 1, &pose};
  const XrHapticContactsGetInfoOMNIX1 contacts{XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1, nullptr, local, now};
  const XrHapticNodeMeshGetInfoOMNIX1 shape{XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1, nullptr, node};
  XrHapticNodeMeshOMNIX1 mesh{XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
  return {scenario.f->nodes(scenario.scene, 0, &count, nullptr),
          scenario.f->get_material(scenario.scene, 0, &material),
          scenario.f->set_material(scenario.scene, 0, &material),
          scenario.f->move(scenario.scene, &update),
          scenario.f->contacts(scenario.scene, &contacts, 0, &count, nullptr),
          scenario.f->mesh(scenario.scene, &shape, &mesh)};
}

XrHapticScenePlacementOMNIX1 In(XrSpace space, float scale = 1) {
  return {XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1, nullptr, space, kHere, scale};
}

XrResult Move(const SceneScenario& scenario, const std::vector<XrHapticNodePoseOMNIX1>& poses,
              XrTime time = Now_ns() + kRuntimeOffset_ns, XrSpace base = XR_NULL_HANDLE) {
  const XrHapticNodesUpdateInfoOMNIX1 info{XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1,  nullptr,     base, time,
                                           static_cast<std::uint32_t>(poses.size()), poses.data()};
  return scenario.f->move(scenario.scene, &info);
}

std::vector<XrHapticSceneNodeOMNIX1> NodesOf(const SceneScenario& scenario) {
  std::uint32_t count = 0;
  EXPECT_EQ(scenario.f->nodes(scenario.scene, 0, &count, nullptr), XR_SUCCESS);
  std::vector<XrHapticSceneNodeOMNIX1> nodes(count, {XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1});
  EXPECT_EQ(scenario.f->nodes(scenario.scene, count, &count, nodes.data()), XR_SUCCESS);
  return nodes;
}

// [Results] LOADING for the first time: it can be placed and enabled, and has no contents yet.
TEST(HapticSceneRules, LoadingSceneCanOnlyBePlacedAndEnabled) {
  SceneScenario scenario;
  ASSERT_EQ(scenario.Create(), XR_SUCCESS);
  ASSERT_NE(scenario.Number(), 0u);
  for (const XrResult result : AskAll(scenario, 1)) EXPECT_EQ(result, XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1);
  const XrHapticScenePlacementOMNIX1 placement = In(scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL));
  EXPECT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  EXPECT_EQ(scenario.f->enable(scenario.scene, XR_FALSE), XR_SUCCESS);
  const XrHapticSceneStateOMNIX1 state = scenario.State();
  EXPECT_EQ(state.status, XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1);
  EXPECT_EQ(state.nodeCount + state.materialCount + state.triangleCount, 0u);
  EXPECT_EQ(state.isFelt, XR_FALSE);
}

// [Results] "anything but its state, its diagnostics and its end"; [Life of a scene] "is FAILED, and stays so".
TEST(HapticSceneRules, FailedSceneStaysFailed) {
  SceneScenario scenario;
  ASSERT_EQ(scenario.Create(), XR_SUCCESS);
  const std::uint32_t number = scenario.Number();
  ASSERT_NE(number, 0u);
  scenario.SayState(number, protocol::HapticSceneStatus::kFailed, 0, "document: /meshes/3: is broken");
  ASSERT_TRUE(scenario.Until([&] { return scenario.State().status == XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1; }));
  for (const XrResult result : AskAll(scenario, 1)) EXPECT_EQ(result, XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1);
  const XrHapticScenePlacementOMNIX1 placement = In(scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL), 2);
  EXPECT_EQ(scenario.f->place(scenario.scene, &placement), XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1);
  EXPECT_EQ(scenario.f->enable(scenario.scene, XR_TRUE), XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1);
  // A late message, and a new service.
  scenario.service->Say(SceneTableMessage(number, TwoNodes()));
  scenario.SayState(number, protocol::HapticSceneStatus::kReady, 9, "");
  const std::int64_t end = Now_ns() + 100'000'000;
  scenario.Until([&] { return Now_ns() > end; });
  EXPECT_EQ(scenario.State().status, XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1);
  EXPECT_NE(scenario.Diagnostics().find("/meshes/3"), std::string::npos);
  scenario.service = nullptr;
  scenario.service = std::make_unique<FakeService>();
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().applications.empty(); }));
  scenario.app->Poll();
  EXPECT_EQ(scenario.State().status, XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1);
  EXPECT_TRUE(scenario.service->heard().scene_loads.empty());
}

// [XrEventDataHapticSceneStateChangedOMNIX1] one for each change of status; none of a scene that was destroyed.
TEST(HapticSceneRules, OneEventPerStatusChangeUntilDestroyed) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  scenario.app->Poll();
  const auto count = [&] { return scenario.app->CountEvents(XR_TYPE_EVENT_DATA_HAPTIC_SCENE_STATE_CHANGED_OMNIX1); };
  EXPECT_EQ(count(), 1) << "READY";
  const XrHapticScenePlacementOMNIX1 placement = In(scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL), 3);
  ASSERT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  scenario.app->Poll();
  EXPECT_EQ(count(), 2) << "another scale: LOADING";
  scenario.SayState(scenario.Number(), protocol::HapticSceneStatus::kReady, 10, "");
  ASSERT_TRUE(scenario.Until([&] { return count() == 3; }));
  scenario.SayState(scenario.Number(), protocol::HapticSceneStatus::kReady, 0, "");
  ASSERT_TRUE(scenario.Until([&] { return scenario.State().isFelt == XR_FALSE; })) << "ready, and not rendered now";
  EXPECT_EQ(count(), 3) << "the status is the same";
  const XrHapticScenePlacementOMNIX1 again = In(placement.baseSpace, 4);
  ASSERT_EQ(scenario.f->place(scenario.scene, &again), XR_SUCCESS);
  ASSERT_EQ(scenario.f->destroy(scenario.scene), XR_SUCCESS);
  scenario.app->Poll();
  EXPECT_EQ(count(), 3) << "its handle is destroyed";
}

// [Results] a 17th moved node, a 17th changed material; the first sixteen still work.
TEST(HapticSceneRules, LimitsMovedNodesAndChangedMaterialsToSixteen) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady(ManyNodes(20, 20)));
  const std::vector<XrHapticSceneNodeOMNIX1> nodes = NodesOf(scenario);
  ASSERT_EQ(nodes.size(), 20u);
  std::vector<XrHapticNodePoseOMNIX1> poses;
  for (const XrHapticSceneNodeOMNIX1& node : nodes) poses.push_back({node.node, 0, kHere, {0, 0, 0}, {0, 0, 0}});
  const std::vector<XrHapticNodePoseOMNIX1> seventeen(poses.begin(), poses.begin() + 17);
  EXPECT_EQ(Move(scenario, seventeen), XR_ERROR_LIMIT_REACHED);
  for (std::size_t i = 0; i < 16; ++i) ASSERT_EQ(Move(scenario, {poses[i]}), XR_SUCCESS);
  EXPECT_EQ(Move(scenario, {poses[16]}), XR_ERROR_LIMIT_REACHED);
  EXPECT_EQ(Move(scenario, {poses[15], poses[0]}), XR_SUCCESS);
  XrHapticMaterialOMNIX1 material{XR_TYPE_HAPTIC_MATERIAL_OMNIX1};
  ASSERT_EQ(scenario.f->get_material(scenario.scene, 0, &material), XR_SUCCESS);
  for (std::uint32_t i = 0; i < 16; ++i) ASSERT_EQ(scenario.f->set_material(scenario.scene, i, &material), XR_SUCCESS);
  EXPECT_EQ(scenario.f->set_material(scenario.scene, 16, &material), XR_ERROR_LIMIT_REACHED);
  EXPECT_EQ(scenario.f->set_material(scenario.scene, 15, &material), XR_SUCCESS);
  EXPECT_EQ(scenario.f->set_material(scenario.scene, 20, &material), XR_ERROR_INDEX_OUT_OF_RANGE);
  ASSERT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_nodes.size() == 17; }));
  ASSERT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_materials.size() == 17; }));
}

// [Results] "An unsuccessful call changes nothing": no pose of an update with one bad pose is ever sent.
TEST(HapticSceneRules, NodeUpdateIsAllOrNothing) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  const std::vector<XrHapticSceneNodeOMNIX1> nodes = NodesOf(scenario);
  const XrHapticNodePoseOMNIX1 good{nodes[1].node, 0, kHere, {0, 0, 0}, {0, 0, 0}};
  XrHapticNodePoseOMNIX1 bad = good;
  bad.node = nodes[0].node;
  EXPECT_EQ(Move(scenario, {good, bad}), XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1);
  bad = good;
  bad.flags = 2;
  EXPECT_EQ(Move(scenario, {good, bad}), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(Move(scenario, {}), XR_ERROR_VALIDATION_FAILURE) << "no pose at all";
  for (const XrTime time : {XrTime{0}, XrTime{-3}}) EXPECT_EQ(Move(scenario, {good}, time), XR_ERROR_TIME_INVALID);
  // In a space that cannot be located nothing moves; errors are still returned.
  const XrTime now = Now_ns() + kRuntimeOffset_ns;
  const XrSpace nowhere = scenario.app->ActionSpace(scenario.app->pose, scenario.app->left);
  omni_test_set_device("left", 0, nullptr);
  ASSERT_EQ(scenario.app->Sync(), XR_SUCCESS);
  EXPECT_EQ(Move(scenario, {good}, now, nowhere), XR_SUCCESS);
  bad.flags = 0;
  bad.node = nodes[0].node;
  EXPECT_EQ(Move(scenario, {bad}, now, nowhere), XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1);
  scenario.service = nullptr;
  ASSERT_TRUE(scenario.Until([&] { return scenario.State().status == XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1; }));
  scenario.service = std::make_unique<FakeService>();
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_enables.empty(); }))
      << "everything was sent again";
  EXPECT_TRUE(scenario.service->heard().scene_nodes.empty());
}

// [Life of a scene] "placement, node poses and materials are as they were last set", ids are those of before.
TEST(HapticSceneRules, NewServiceReceivesPlacementAndPoses) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  const std::vector<XrHapticSceneNodeOMNIX1> nodes = NodesOf(scenario);
  XrHapticScenePlacementOMNIX1 placement = In(scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL));
  placement.pose.position = {0.1f, 0.2f, -0.3f};
  ASSERT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  ASSERT_EQ(Move(scenario, {{nodes[1].node, 0, {{0, 0, 0, 1}, {0.1f, 0.4f, 0}}, {0, 0, 0}, {0, 0, 0}}}), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_nodes.empty(); }));
  const Heard before = scenario.service->heard();
  scenario.service = nullptr;
  ASSERT_TRUE(scenario.Until([&] { return scenario.State().status == XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1; }));
  EXPECT_EQ(scenario.State().isFelt, XR_FALSE);
  scenario.service = std::make_unique<FakeService>();
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_enables.empty(); }));
  const Heard after = scenario.service->heard();
  ASSERT_EQ(after.scene_places.size(), 1u);
  EXPECT_EQ(after.scene_places[0].pose.position_m, before.scene_places.back().pose.position_m);
  ASSERT_EQ(after.scene_nodes.size(), 1u);
  EXPECT_EQ(after.scene_nodes[0].nodes[0].pose.position_m, before.scene_nodes.back().nodes[0].pose.position_m);
  EXPECT_EQ(NodesOf(scenario)[1].node, nodes[1].node) << "LOADING again: they are those of the document";
}

// [Frames] baseSpace is looked up at every xrWaitFrame; where it cannot be located the scene stays.
TEST(HapticSceneRules, PlacementFollowsItsSpace) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  const float head[7] = {0, 1.6f, -0.5f, 0, 0, 0, 1};
  const float moving[6] = {0.3f, 0, 0, 0, 0, 0};
  ASSERT_EQ(omni_test_set_head(head, moving), 0);
  const XrHapticScenePlacementOMNIX1 in_view = In(scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW));
  ASSERT_EQ(scenario.f->place(scenario.scene, &in_view), XR_SUCCESS);
  const auto frame = [&] {
    XrFrameState state{XR_TYPE_FRAME_STATE};
    EXPECT_EQ(xrWaitFrame(scenario.app->session, nullptr, &state), XR_SUCCESS);
    EXPECT_GE(xrBeginFrame(scenario.app->session, nullptr), XR_SUCCESS);
    const XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO,           nullptr, state.predictedDisplayTime,
                             XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0,       nullptr};
    EXPECT_EQ(xrEndFrame(scenario.app->session, &end), XR_SUCCESS);
    return state.predictedDisplayTime;
  };
  const XrTime shown = frame();
  ASSERT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_places.size() >= 2; }));
  const protocol::HapticScenePlace place = scenario.service->heard().scene_places[1];
  EXPECT_NEAR(static_cast<double>(place.t_ns), static_cast<double>(shown - kRuntimeOffset_ns), 2e6);
  EXPECT_NEAR(place.pose.velocity_m_s[0], 0.3, 1e-4) << "x of LOCAL is x of the base";
  // A controller's space, which is lost.
  const XrHapticScenePlacementOMNIX1 in_hand = In(scenario.app->ActionSpace(scenario.app->pose, scenario.app->left));
  ASSERT_EQ(scenario.app->Sync(), XR_SUCCESS);
  ASSERT_EQ(scenario.f->place(scenario.scene, &in_hand), XR_SUCCESS);
  const float away[7] = {1, 1, 1, 0, 0, 0, 1};
  omni_test_set_tracking("left", 0, 0);
  ASSERT_EQ(omni_test_set_pose("/user/hand/left/input/grip/pose", away, nullptr), 0);
  ASSERT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_places.size() >= 3; }));
  const std::size_t reported = scenario.service->heard().scene_places.size();
  frame();
  frame();
  const std::int64_t end = Now_ns() + 50'000'000;
  scenario.Until([&] { return Now_ns() > end; });
  EXPECT_EQ(scenario.service->heard().scene_places.size(), reported);
  omni_test_set_tracking("left", 1, 1);
  frame();
  EXPECT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_places.size() > reported; }));
  ASSERT_EQ(xrDestroySpace(in_hand.baseSpace), XR_SUCCESS);
  frame();
  EXPECT_EQ(scenario.State().status, XR_HAPTIC_SCENE_STATUS_READY_OMNIX1) << "it stays where it was";
}

// [Valid usage] a scale is finite and clamped to its range; `next` is ignored.
TEST(HapticSceneRules, ScaleIsClampedToRange) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  XrHapticScenePlacementOMNIX1 placement = In(scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL), 1e9f);
  XrBaseInStructure unknown{static_cast<XrStructureType>(1999999999), nullptr};
  placement.next = &unknown;
  ASSERT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  placement.scale = -1;
  ASSERT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_places.size() == 2; }));
  EXPECT_EQ(scenario.service->heard().scene_places[0].scale, 1e4);
  EXPECT_EQ(scenario.service->heard().scene_places[1].scale, 1e-4);
}

// [Results] node ids belong to one scene; only changing nodes have a mesh, once a shape has arrived.
TEST(HapticSceneRules, RejectsNodesOfOtherScenesAndMeshesOfRigidNodes) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  const std::vector<XrHapticSceneNodeOMNIX1> old = NodesOf(scenario);
  const auto mesh_of = [&](XrHapticNodeIdOMNIX1 node) {
    const XrHapticNodeMeshGetInfoOMNIX1 info{XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1, nullptr, node};
    XrHapticNodeMeshOMNIX1 mesh{XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
    return scenario.f->mesh(scenario.scene, &info, &mesh);
  };
  EXPECT_EQ(mesh_of(old[1].node), XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1) << "it never changes";
  EXPECT_EQ(mesh_of(XR_NULL_HAPTIC_NODE_ID_OMNIX1), XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1);
  EXPECT_EQ(mesh_of(old[0].node), XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1) << "this service publishes no shapes";
  ASSERT_EQ(scenario.f->destroy(scenario.scene), XR_SUCCESS);
  ASSERT_EQ(scenario.Create(), XR_SUCCESS);
  const std::uint32_t number = scenario.Number(2);
  scenario.service->Say(SceneTableMessage(number, TwoNodes()));
  scenario.SayState(number, protocol::HapticSceneStatus::kReady, 11, "");
  ASSERT_TRUE(scenario.Until([&] { return scenario.State().status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1; }));
  EXPECT_EQ(Move(scenario, {{old[1].node, 0, kHere, {0, 0, 0}, {0, 0, 0}}}), XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1);
  EXPECT_EQ(Move(scenario, {{NodesOf(scenario)[1].node, 0, kHere, {0, 0, 0}, {0, 0, 0}}}), XR_SUCCESS);
}

// [Life of a scene] rendered while it is enabled and its session focused: what is sent to the service, and what it
// reports.
TEST(HapticSceneRules, IsFeltFollowsTheService) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  EXPECT_EQ(scenario.State().isFelt, XR_TRUE);
  ASSERT_EQ(scenario.f->enable(scenario.scene, XR_FALSE), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_enables.size() >= 2; }));
  EXPECT_EQ(scenario.service->heard().scene_enables.back().enabled, 0u);
  scenario.SayState(scenario.Number(), protocol::HapticSceneStatus::kReady, 0, "");
  EXPECT_TRUE(scenario.Until([&] { return scenario.State().isFelt == XR_FALSE; }));
  ASSERT_EQ(scenario.f->enable(scenario.scene, XR_TRUE), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_enables.size() >= 3; }));
  EXPECT_EQ(scenario.service->heard().scene_enables.back().enabled, 1u);
}

}  // namespace test_haptic_scene_rules
}  // namespace omni::test
