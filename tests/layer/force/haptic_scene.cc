// XR_OMNIX1_haptic_scene through the real loader: what the service receives, and what the application gets back.
#include <cmath>
#include <cstdio>
#include <string>

#include "layer/src/spaces/locate.h"
#include "tests/layer/support/scene_scenario.h"

namespace omni::test {
namespace test_haptic_scene {

TEST(HapticScene, FunctionsNeedBothExtensions) {
  for (const bool scene : {false, true}) {
    AppOptions options;
    options.extensions.push_back(XR_OMNIX1_FORCE_FEEDBACK_EXTENSION_NAME);
    if (scene) options.extensions.push_back(XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME);
    const App app(options);
    const SceneFunctions f(app.instance);
    EXPECT_EQ(f.create != nullptr, scene);
    EXPECT_EQ(f.mesh != nullptr, scene);
  }
}

// As for every extension that depends on another one: no instance, and no runtime is asked for one.
TEST(HapticScene, WithoutForceFeedbackThereIsNoInstance) {
  const char* const extension = XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME;
  XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
  std::snprintf(info.applicationInfo.applicationName, sizeof(info.applicationInfo.applicationName), "scene");
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 20);
  info.enabledApiLayerCount = 1;
  info.enabledApiLayerNames = &kLayer;
  info.enabledExtensionCount = 1;
  info.enabledExtensionNames = &extension;
  const long before = omni_test_call_count("xrCreateInstance");
  XrInstance instance = XR_NULL_HANDLE;
  EXPECT_EQ(xrCreateInstance(&info, &instance), kErrorExtensionDependencyNotEnabled);
  EXPECT_EQ(instance, static_cast<XrInstance>(XR_NULL_HANDLE));
  EXPECT_EQ(omni_test_call_count("xrCreateInstance"), before);
}

TEST(HapticScene, SendsDocumentAndReportsServiceState) {
  SceneScenario scenario;
  ASSERT_EQ(scenario.Create(), XR_SUCCESS);
  EXPECT_EQ(scenario.State().status, XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1);
  XrHapticSceneOMNIX1 second = XR_NULL_HANDLE;
  const std::uint8_t byte = 0;
  XrHapticSceneCreateInfoOMNIX1 info{XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1, nullptr, 0, 1, &byte};
  EXPECT_EQ(scenario.f->create(scenario.app->session, &info, &second), XR_ERROR_LIMIT_REACHED);
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_documents.empty(); }));
  EXPECT_EQ(scenario.service->heard().scene_documents[0], kDocument);
  std::uint32_t count = 0;
  EXPECT_EQ(scenario.f->nodes(scenario.scene, 0, &count, nullptr), XR_ERROR_HAPTIC_SCENE_NOT_READY_OMNIX1);
  const std::uint32_t number = scenario.service->heard().scene_loads[0].number;
  scenario.service->Say(SceneTableMessage(number, TwoNodes()));
  scenario.SayState(number, protocol::HapticSceneStatus::kReady, 9, "a warning");
  ASSERT_TRUE(scenario.Until(
      [&] { return scenario.app->CountEvents(XR_TYPE_EVENT_DATA_HAPTIC_SCENE_STATE_CHANGED_OMNIX1) > 0; }));
  const XrHapticSceneStateOMNIX1 state = scenario.State();
  EXPECT_EQ(state.status, XR_HAPTIC_SCENE_STATUS_READY_OMNIX1);
  EXPECT_EQ(state.isFelt, XR_TRUE);
  EXPECT_EQ(state.nodeCount, 2u);
  EXPECT_EQ(state.triangleCount, 12u);
  EXPECT_EQ(state.loadTime, 5'000'000);
  EXPECT_EQ(scenario.Diagnostics(), "a warning");
  ASSERT_EQ(scenario.f->nodes(scenario.scene, 0, &count, nullptr), XR_SUCCESS);
  ASSERT_EQ(count, 2u);
  XrHapticSceneNodeOMNIX1 nodes[2] = {{XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1}, {XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1}};
  EXPECT_EQ(scenario.f->nodes(scenario.scene, 1, &count, nodes), XR_ERROR_SIZE_INSUFFICIENT);
  ASSERT_EQ(scenario.f->nodes(scenario.scene, 2, &count, nodes), XR_SUCCESS);
  EXPECT_STREQ(nodes[0].name, "still");
  EXPECT_EQ(nodes[1].gltfNode, 2);
  EXPECT_EQ(nodes[0].flags, XR_HAPTIC_NODE_SOFT_BIT_OMNIX1);
  EXPECT_EQ(nodes[1].flags, XR_HAPTIC_NODE_KINEMATIC_BIT_OMNIX1);
  EXPECT_FLOAT_EQ(nodes[1].restPose.position.y, 0.3f);
  EXPECT_EQ(scenario.f->destroy(scenario.scene), XR_SUCCESS);
  EXPECT_EQ(scenario.f->destroy(scenario.scene), XR_ERROR_HANDLE_INVALID);
  EXPECT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_ends.size() == 1; }));
  EXPECT_EQ(scenario.Create(), XR_SUCCESS) << "after the first one is destroyed";
}

TEST(HapticScene, FailedSceneReportsWhyAndCanOnlyBeDestroyed) {
  SceneScenario scenario;
  ASSERT_EQ(scenario.Create(), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_loads.empty(); }));
  scenario.SayState(scenario.service->heard().scene_loads[0].number, protocol::HapticSceneStatus::kFailed, 0,
                    "document: /meshes/3: is broken");
  ASSERT_TRUE(scenario.Until([&] { return scenario.State().status == XR_HAPTIC_SCENE_STATUS_FAILED_OMNIX1; }));
  EXPECT_NE(scenario.Diagnostics().find("/meshes/3"), std::string::npos);
  std::uint32_t count = 0;
  EXPECT_EQ(scenario.f->nodes(scenario.scene, 0, &count, nullptr), XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1);
  EXPECT_EQ(scenario.f->enable(scenario.scene, XR_TRUE), XR_ERROR_HAPTIC_SCENE_INVALID_OMNIX1);
  EXPECT_EQ(scenario.f->destroy(scenario.scene), XR_SUCCESS);
}

// The document's frame at a placement in LOCAL: where the service puts the scene, against the algebra written out.
TEST(HapticScene, PlacementIsSentInBaseFrame) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  const XrSpace local = scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  XrHapticScenePlacementOMNIX1 placement{
      XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1, nullptr, local, {{0, 0, 0, 1}, {0, 0, 0}}, 2};
  placement.pose = {{0, std::sqrt(0.5f), 0, std::sqrt(0.5f)}, {0.1f, 0.2f, -0.3f}};
  ASSERT_EQ(scenario.f->place(scenario.scene, &placement), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_places.empty(); }));
  const protocol::HapticScenePlace place = scenario.service->heard().scene_places.back();
  EXPECT_EQ(place.scale, 2);
  // A point of the document: placed by the application in LOCAL; by the message in the base, then in LOCAL.
  const layer::Pose X_LO = layer::DefaultBasePose();
  const glm::dvec3 p_G(0.01, 0.02, 0.03);
  const layer::Pose X_LG = layer::FromXr(placement.pose);
  const glm::dvec3 p_L = X_LG.p + X_LG.q * (2.0 * p_G);
  const glm::dvec3 p_Z = 2.0 * glm::dvec3(p_G.x, -p_G.z, p_G.y);
  const auto& q = place.pose.rotation_wxyz;
  const auto& t = place.pose.position_m;
  const glm::dvec3 p_O = glm::dquat(q[0], q[1], q[2], q[3]) * p_Z + glm::dvec3(t[0], t[1], t[2]);
  const glm::dvec3 reported_L = X_LO.p + X_LO.q * p_O;
  EXPECT_NEAR(reported_L.x, p_L.x, 1e-6);
  EXPECT_NEAR(reported_L.y, p_L.y, 1e-6);
  EXPECT_NEAR(reported_L.z, p_L.z, 1e-6);
  EXPECT_EQ(scenario.State().status, XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1) << "another scale is another scene";
}

// A node at rest is sent as no motion; a move, a turn and a velocity as what they do to the document's points.
TEST(HapticScene, NodePosesAreSentRelativeToRestPose) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  XrHapticSceneNodeOMNIX1 nodes[2] = {{XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1}, {XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1}};
  std::uint32_t count = 0;
  ASSERT_EQ(scenario.f->nodes(scenario.scene, 2, &count, nodes), XR_SUCCESS);
  XrHapticNodePoseOMNIX1 pose{nodes[1].node, 0, nodes[1].restPose, {0, 0, 0}, {0, 0, 0}};
  XrHapticNodesUpdateInfoOMNIX1 info{
      XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1, nullptr, XR_NULL_HANDLE, Now_ns() + kRuntimeOffset_ns, 1, &pose};
  const auto reported = [&](std::size_t n) {
    EXPECT_TRUE(scenario.Until([&] { return scenario.service->heard().scene_nodes.size() >= n; }));
    const auto heard = scenario.service->heard().scene_nodes;
    return heard.empty() ? protocol::HapticNodes{} : heard.back();
  };
  ASSERT_EQ(scenario.f->move(scenario.scene, &info), XR_SUCCESS);
  const protocol::HapticNodes rest = reported(1);
  ASSERT_EQ(rest.count, 1u);
  EXPECT_EQ(rest.nodes[0].object, 1u);
  EXPECT_NEAR(static_cast<double>(rest.t_ns), static_cast<double>(info.time - kRuntimeOffset_ns), 2e6);
  for (const double x : rest.nodes[0].pose.position_m) EXPECT_NEAR(x, 0, 1e-7);
  EXPECT_NEAR(std::abs(rest.nodes[0].pose.rotation_wxyz[0]), 1, 1e-9);

  // A quarter turn about the document's y through the node, which rises at 1 m/s and turns at 2 rad/s about y.
  pose.pose.orientation = {0, std::sqrt(0.5f), 0, std::sqrt(0.5f)};
  pose.linearVelocity = {0, 1, 0};
  pose.angularVelocity = {0, 2, 0};
  pose.flags = XR_HAPTIC_NODE_POSE_TELEPORT_BIT_OMNIX1;
  ASSERT_EQ(scenario.f->move(scenario.scene, &info), XR_SUCCESS);
  const protocol::HapticNodePose turned = reported(2).nodes[0];
  EXPECT_EQ(turned.flags, protocol::kPoseLeaps);
  const auto& q = turned.pose.rotation_wxyz;
  const auto& t = turned.pose.position_m;
  const auto carried = [&](const glm::dvec3& rest_G) {  // by the service, in its frame (x, -z, y)
    return glm::dquat(q[0], q[1], q[2], q[3]) * glm::dvec3(rest_G.x, -rest_G.z, rest_G.y) +
           glm::dvec3(t[0], t[1], t[2]);
  };
  const glm::dvec3 origin = carried({0.1, 0.3, 0}), beside = carried({0.2, 0.3, 0});
  EXPECT_NEAR(glm::length(origin - glm::dvec3(0.1, 0, 0.3)), 0, 1e-6) << "the node's own origin stays";
  EXPECT_NEAR(glm::length(beside - glm::dvec3(0.1, 0.1, 0.3)), 0, 1e-6)
      << "+x goes to -z of the document, +y of the base";
  // v of the node's origin: that of the frame's origin and w x arm.
  const auto& v = turned.pose.velocity_m_s;
  const auto& w = turned.pose.angular_velocity_rad_s;
  const glm::dvec3 arm = origin - glm::dvec3(t[0], t[1], t[2]);
  const glm::dvec3 v_node = glm::dvec3(v[0], v[1], v[2]) + glm::cross(glm::dvec3(w[0], w[1], w[2]), arm);
  EXPECT_NEAR(glm::length(v_node - glm::dvec3(0, 0, 1)), 0, 1e-6);
  EXPECT_NEAR(w[2], 2, 1e-6);

  pose.node = nodes[0].node;
  EXPECT_EQ(scenario.f->move(scenario.scene, &info), XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1) << "it is not kinematic";
  pose.node = 77;
  EXPECT_EQ(scenario.f->move(scenario.scene, &info), XR_ERROR_HAPTIC_NODE_INVALID_OMNIX1);
  pose.pose.orientation = {0, 0, 0, 0};
  EXPECT_EQ(scenario.f->move(scenario.scene, &info), XR_ERROR_POSE_INVALID);
  pose.pose = nodes[1].restPose;
  pose.linearVelocity.x = std::nanf("");
  EXPECT_EQ(scenario.f->move(scenario.scene, &info), XR_ERROR_VALIDATION_FAILURE);
  info.time = 0;
  EXPECT_EQ(scenario.f->move(scenario.scene, &info), XR_ERROR_TIME_INVALID);
  EXPECT_EQ(scenario.service->heard().scene_nodes.size(), 2u) << "what fails changes nothing";
}

TEST(HapticScene, MaterialsAreReadSetAndClampedToRange) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  XrHapticMaterialOMNIX1 material{XR_TYPE_HAPTIC_MATERIAL_OMNIX1};
  ASSERT_EQ(scenario.f->get_material(scenario.scene, 0, &material), XR_SUCCESS);
  EXPECT_EQ(material.stiffness, 444);
  EXPECT_EQ(scenario.f->get_material(scenario.scene, 1, &material), XR_ERROR_INDEX_OUT_OF_RANGE);
  material.stiffness = 1e6f;
  material.staticFriction = 0.3f;
  material.dynamicFriction = 0.7f;
  ASSERT_EQ(scenario.f->set_material(scenario.scene, 0, &material), XR_SUCCESS);
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_materials.empty(); }));
  const base::MaterialParameters reported = scenario.service->heard().scene_materials[0].parameters;
  EXPECT_EQ(reported.stiffness_N_m, 2000);
  EXPECT_FLOAT_EQ(static_cast<float>(reported.dynamic_friction), 0.3f) << "never above the static one";
  ASSERT_EQ(scenario.f->get_material(scenario.scene, 0, &material), XR_SUCCESS);
  EXPECT_EQ(material.stiffness, 2000);
  material.damping = std::nanf("");
  EXPECT_EQ(scenario.f->set_material(scenario.scene, 0, &material), XR_ERROR_VALIDATION_FAILURE);
}

TEST(HapticScene, ContactsAreReportedInRequestedSpace) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  protocol::ContactSnapshot touched;
  touched.scene_generation = 9;
  touched.count = 1;
  protocol::ContactSample& contact = touched.contacts[0];
  contact.object = 1;
  contact.point_base_m = {0.01, 0.02, 0.05};
  contact.normal_base = {0, 0, 1};
  contact.force_base_N = {0, 0.1, 0.5};
  contact.slip_base_m_s = {0.2, 0, 0};
  contact.normal_force_N = 0.5;
  contact.penetration_m = 0.001;
  scenario.service->SetContacts(touched);
  scenario.service->Fill();
  const XrSpace local = scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL);
  XrHapticContactsGetInfoOMNIX1 info{XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1, nullptr, local,
                                     Now_ns() + kRuntimeOffset_ns};
  std::uint32_t count = 0;
  ASSERT_TRUE(scenario.Until(
      [&] { return scenario.f->contacts(scenario.scene, &info, 0, &count, nullptr) == XR_SUCCESS && count == 1; }));
  XrHapticContactOMNIX1 got{XR_TYPE_HAPTIC_CONTACT_OMNIX1};
  ASSERT_EQ(scenario.f->contacts(scenario.scene, &info, 1, &count, &got), XR_SUCCESS);
  const layer::Pose X_LO = layer::DefaultBasePose();
  const glm::dvec3 p_L = X_LO.p + X_LO.q * glm::dvec3(0.01, 0.02, 0.05);
  EXPECT_NEAR(got.point.x, p_L.x, 1e-6);
  EXPECT_NEAR(got.point.y, p_L.y, 1e-6);
  EXPECT_NEAR(got.point.z, p_L.z, 1e-6);
  EXPECT_NEAR(got.normal.y, 1, 1e-6) << "the base's z is up, as LOCAL's y";
  EXPECT_NEAR(got.force.y, 0.5, 1e-6);
  EXPECT_FLOAT_EQ(got.penetration, 0.001f);
  EXPECT_GT(got.time, 0);
  // Contacts of another scene: none of ours is touched.
  touched.scene_generation = 10;
  scenario.service->SetContacts(touched);
  ASSERT_TRUE(scenario.Until(
      [&] { return scenario.f->contacts(scenario.scene, &info, 0, &count, nullptr) == XR_SUCCESS && count == 0; }));
  info.time = 0;
  EXPECT_EQ(scenario.f->contacts(scenario.scene, &info, 0, &count, nullptr), XR_ERROR_TIME_INVALID);
}

// The service is replaced: the same scene is loaded in the new one, with all that was set.
TEST(HapticScene, SceneIsReloadedInRestartedService) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  XrHapticMaterialOMNIX1 material{XR_TYPE_HAPTIC_MATERIAL_OMNIX1};
  ASSERT_EQ(scenario.f->get_material(scenario.scene, 0, &material), XR_SUCCESS);
  material.stiffness = 100;
  ASSERT_EQ(scenario.f->set_material(scenario.scene, 0, &material), XR_SUCCESS);
  ASSERT_EQ(scenario.f->enable(scenario.scene, XR_FALSE), XR_SUCCESS);
  scenario.service = nullptr;
  ASSERT_TRUE(scenario.Until([&] { return scenario.State().status == XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1; }));
  EXPECT_NE(scenario.Diagnostics().find("waiting for omnid"), std::string::npos);
  scenario.service = std::make_unique<FakeService>();
  ASSERT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_enables.empty(); }));
  const Heard heard = scenario.service->heard();
  ASSERT_EQ(heard.scene_documents.size(), 1u);
  EXPECT_EQ(heard.scene_documents[0], kDocument);
  ASSERT_EQ(heard.scene_materials.size(), 1u);
  EXPECT_EQ(heard.scene_materials[0].parameters.stiffness_N_m, 100);
  EXPECT_EQ(heard.scene_enables[0].enabled, 0u);
}

TEST(HapticScene, WaitsForServiceAndThenLoads) {
  SceneScenario scenario(false);
  ASSERT_EQ(scenario.Create(), XR_SUCCESS);
  EXPECT_EQ(scenario.State().status, XR_HAPTIC_SCENE_STATUS_LOADING_OMNIX1);
  EXPECT_NE(scenario.Diagnostics().find("waiting for omnid"), std::string::npos);
  scenario.service = std::make_unique<FakeService>();
  EXPECT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_loads.empty(); }));
}

TEST(HapticScene, EndsWithItsSession) {
  SceneScenario scenario;
  ASSERT_TRUE(scenario.GetReady());
  ASSERT_EQ(xrEndSession(scenario.app->session), XR_ERROR_SESSION_NOT_STOPPING);
  ASSERT_EQ(xrDestroySession(scenario.app->session), XR_SUCCESS);
  scenario.app->session = XR_NULL_HANDLE;
  XrHapticSceneStateOMNIX1 state{XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1};
  EXPECT_EQ(scenario.f->state(scenario.scene, &state), XR_ERROR_HANDLE_INVALID);
  EXPECT_TRUE(scenario.Until([&] { return !scenario.service->heard().scene_ends.empty(); }));
}

TEST(HapticScene, InvalidArgumentsAreRejected) {
  SceneScenario scenario;
  const std::uint8_t byte = 0;
  const XrHapticSceneCreateInfoOMNIX1 good{XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1, nullptr, 0, 1, &byte};
  const auto create = [&](auto change) {
    XrHapticSceneCreateInfoOMNIX1 info = good;
    change(info);
    return scenario.f->create(scenario.app->session, &info, &scenario.scene);
  };
  EXPECT_EQ(scenario.f->create(scenario.app->session, nullptr, &scenario.scene), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(scenario.f->create(scenario.app->session, &good, nullptr), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(create([](auto& i) { i.type = XR_TYPE_SESSION_CREATE_INFO; }), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(create([](auto& i) { i.bufferByteCount = 0; }), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(create([](auto& i) { i.bufferByteCount = XR_MAX_HAPTIC_SCENE_BYTES_OMNIX1 + 1; }),
            XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(create([](auto& i) { i.buffer = nullptr; }), XR_ERROR_VALIDATION_FAILURE);
  EXPECT_EQ(create([](auto& i) { i.createFlags = 4; }), XR_ERROR_VALIDATION_FAILURE);
  const auto wrong = reinterpret_cast<XrHapticSceneOMNIX1>(std::uintptr_t{0x1234560});
  XrHapticSceneStateOMNIX1 state{XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1};
  EXPECT_EQ(scenario.f->state(wrong, &state), XR_ERROR_HANDLE_INVALID);
  EXPECT_EQ(scenario.f->enable(wrong, XR_TRUE), XR_ERROR_HANDLE_INVALID);
  ASSERT_TRUE(scenario.GetReady());
  state.type = XR_TYPE_SESSION_CREATE_INFO;
  EXPECT_EQ(scenario.f->state(scenario.scene, &state), XR_ERROR_VALIDATION_FAILURE);
  XrHapticScenePlacementOMNIX1 placement{XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1,
                                         nullptr,
                                         scenario.app->ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL),
                                         {{0, 0, 0, 0}, {0, 0, 0}},
                                         1};
  EXPECT_EQ(scenario.f->place(scenario.scene, &placement), XR_ERROR_POSE_INVALID);
  placement.pose = {{0, 0, 0, 1}, {0, 1e7f, 0}};
  EXPECT_EQ(scenario.f->place(scenario.scene, &placement), XR_ERROR_POSE_INVALID);
  placement.pose.position.y = 0;
  placement.scale = std::nanf("");
  EXPECT_EQ(scenario.f->place(scenario.scene, &placement), XR_ERROR_VALIDATION_FAILURE);
  placement.scale = 1;
  placement.baseSpace = reinterpret_cast<XrSpace>(std::uintptr_t{0x77});
  EXPECT_EQ(scenario.f->place(scenario.scene, &placement), XR_ERROR_HANDLE_INVALID);
  EXPECT_TRUE(scenario.service->heard().scene_places.empty());
}

}  // namespace test_haptic_scene
}  // namespace omni::test
