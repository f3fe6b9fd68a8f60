// The whole way: an OpenXR application over the loader, the layer, a real omnid and its twin. It gives a scene, moves a
// node, reads contacts and deformed vertices, and the pen feels it.
#include <gtest/gtest.h>
#include <openxr/openxr.h>
#include <stdlib.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <string>
#include <vector>

#include "layer/include/openxr/omni_haptic_scene.h"
#include "tests/support/box_document.h"
#include "tests/support/service_process.h"

namespace omni::test {
namespace {

// Down to 45 mm over the base's centre and held there.
constexpr const char* kStay = R"({"name": "stay", "repeat": false, "waypoints": [
  {"s": 0, "tip_m": [0, 0, 0.070], "axis": [0, 0, -1]},
  {"s": 0.5, "tip_m": [0, 0, 0.046], "axis": [0, 0, -1]},
  {"s": 120, "tip_m": [0, 0, 0.046], "axis": [0, 0, -1]}]})";

// Where the base's centre is in LOCAL while nobody has aligned it.
constexpr XrPosef kBaseInLocal = {{0, 0, 0, 1}, {0, -0.35f, -0.45f}};

class Stack {
 public:
  explicit Stack(const ServiceProcess& service) {
    const std::string build = OMNI_BINARY_DIR;
    setenv("XR_RUNTIME_JSON", (build + "/share/openxr/1/omni_test_runtime.json").c_str(), 1);
    setenv("XR_API_LAYER_PATH", (build + "/share/openxr/1/api_layers/explicit.d").c_str(), 1);
    setenv("OMNI_SOCKET", service.socket_path().c_str(), 1);
    unsetenv("XR_ENABLE_API_LAYERS");
    const char* layer = "XR_APILAYER_OMNI_stylus";
    const char* extensions[] = {"XR_MND_headless", "XR_KHR_convert_timespec_time", "XR_OMNIX1_force_feedback",
                                XR_OMNIX1_HAPTIC_SCENE_EXTENSION_NAME};
    XrInstanceCreateInfo info{XR_TYPE_INSTANCE_CREATE_INFO};
    std::strcpy(info.applicationInfo.applicationName, "stack test");
    info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 20);
    info.enabledApiLayerCount = 1;
    info.enabledApiLayerNames = &layer;
    info.enabledExtensionCount = static_cast<std::uint32_t>(std::size(extensions));
    info.enabledExtensionNames = extensions;
    Must(xrCreateInstance(&info, &instance));
    XrSystemId system = XR_NULL_SYSTEM_ID;
    const XrSystemGetInfo get{XR_TYPE_SYSTEM_GET_INFO, nullptr, XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY};
    Must(xrGetSystem(instance, &get, &system));
    const XrSessionCreateInfo create{XR_TYPE_SESSION_CREATE_INFO, nullptr, 0, system};
    Must(xrCreateSession(instance, &create, &session));
    const XrReferenceSpaceCreateInfo space{
        XR_TYPE_REFERENCE_SPACE_CREATE_INFO, nullptr, XR_REFERENCE_SPACE_TYPE_LOCAL, {{0, 0, 0, 1}, {0, 0, 0}}};
    Must(xrCreateReferenceSpace(session, &space, &local));
  }
  ~Stack() { xrDestroyInstance(instance); }
  Stack(const Stack&) = delete;
  Stack& operator=(const Stack&) = delete;

  static void Must(XrResult result) { EXPECT_EQ(result, XR_SUCCESS); }

  template <class Function>
  Function Get(const char* name) const {
    PFN_xrVoidFunction function = nullptr;
    EXPECT_EQ(xrGetInstanceProcAddr(instance, name, &function), XR_SUCCESS) << name;
    return reinterpret_cast<Function>(function);
  }

  void Poll() {
    XrEventDataBuffer event{XR_TYPE_EVENT_DATA_BUFFER};
    while (xrPollEvent(instance, &event) == XR_SUCCESS) {
      if (event.type == XR_TYPE_EVENT_DATA_HAPTIC_SCENE_STATE_CHANGED_OMNIX1) ++scene_events;
      if (event.type == XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) {
        XrEventDataSessionStateChanged changed;
        std::memcpy(&changed, &event, sizeof(changed));
        state = changed.state;
        const XrSessionBeginInfo begin{XR_TYPE_SESSION_BEGIN_INFO, nullptr, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO};
        if (state == XR_SESSION_STATE_READY) Must(xrBeginSession(session, &begin));
      }
      event = {XR_TYPE_EVENT_DATA_BUFFER};
    }
  }

  // Frame after frame until `done` says so.
  template <class Done>
  bool Until(int ms, Done done) {
    const std::int64_t end_ns = base::MonotonicNow_ns() + std::int64_t{ms} * 1'000'000;
    while (base::MonotonicNow_ns() < end_ns) {
      Poll();
      const bool runs = state == XR_SESSION_STATE_SYNCHRONIZED || state == XR_SESSION_STATE_VISIBLE ||
                        state == XR_SESSION_STATE_FOCUSED;
      XrFrameState frame{XR_TYPE_FRAME_STATE};
      if (runs && xrWaitFrame(session, nullptr, &frame) == XR_SUCCESS) {
        time = frame.predictedDisplayTime;
        xrBeginFrame(session, nullptr);
        const XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO, nullptr, time, XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0, nullptr};
        xrEndFrame(session, &end);
      }
      if (done()) return true;
      SleepMs(5);
    }
    return false;
  }

  XrInstance instance = XR_NULL_HANDLE;
  XrSession session = XR_NULL_HANDLE;
  XrSpace local = XR_NULL_HANDLE;
  XrSessionState state = XR_SESSION_STATE_UNKNOWN;
  XrTime time = 0;
  int scene_events = 0;
};

TEST(StackHapticScene, AnApplicationGivesAScenePlacesMovesAndReadsIt) {
  const TempFolder folder;
  ServiceProcess service(folder.Path("none.glb"), kStay);
  service.Start();
  Stack stack(service);
  ASSERT_TRUE(stack.Until(5000, [&] { return stack.state == XR_SESSION_STATE_FOCUSED; }));

  const std::string document =
      Document({{"clay",
                 0.02,
                 0.040,
                 0.050,
                 {{"stiffness", 300}, {"extrude", {{"step", 0.004}, {"grabForce", 0.15}, {"dwell", 0.1}}}}},
                {"lid", 0.01, 0.300, 0.305, {{"stiffness", 300}, {"kinematic", true}}}});
  XrHapticSceneCreateInfoOMNIX1 create{XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1};
  create.bufferByteCount = static_cast<std::uint32_t>(document.size());
  create.buffer = reinterpret_cast<const std::uint8_t*>(document.data());
  XrHapticSceneOMNIX1 scene = XR_NULL_HANDLE;
  ASSERT_EQ(stack.Get<PFN_xrCreateHapticSceneOMNIX1>("xrCreateHapticSceneOMNIX1")(stack.session, &create, &scene),
            XR_SUCCESS);
  const auto place = stack.Get<PFN_xrSetHapticScenePlacementOMNIX1>("xrSetHapticScenePlacementOMNIX1");
  const XrHapticScenePlacementOMNIX1 placement{XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1, nullptr, stack.local,
                                               kBaseInLocal, 1};
  ASSERT_EQ(place(scene, &placement), XR_SUCCESS);
  const auto get_state = stack.Get<PFN_xrGetHapticSceneStateOMNIX1>("xrGetHapticSceneStateOMNIX1");
  XrHapticSceneStateOMNIX1 state{XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1};
  ASSERT_TRUE(stack.Until(5000, [&] {
    return get_state(scene, &state) == XR_SUCCESS && state.status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1 &&
           state.isFelt;
  }));
  ASSERT_EQ(state.nodeCount, 2U);
  EXPECT_EQ(stack.scene_events, 1);
  XrHapticSceneNodeOMNIX1 nodes[2] = {{XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1}, {XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1}};
  std::uint32_t count = 0;
  ASSERT_EQ(
      stack.Get<PFN_xrEnumerateHapticSceneNodesOMNIX1>("xrEnumerateHapticSceneNodesOMNIX1")(scene, 2, &count, nodes),
      XR_SUCCESS);

  // Contacts, in LOCAL.
  const auto contacts = stack.Get<PFN_xrEnumerateHapticContactsOMNIX1>("xrEnumerateHapticContactsOMNIX1");
  std::vector<XrHapticContactOMNIX1> touched;
  const auto touches = [&](XrHapticNodeIdOMNIX1 node) {
    const XrHapticContactsGetInfoOMNIX1 info{XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1, nullptr, stack.local, stack.time};
    touched.assign(8, {XR_TYPE_HAPTIC_CONTACT_OMNIX1});
    if (contacts(scene, &info, 8, &count, touched.data()) != XR_SUCCESS) return false;
    touched.resize(count);
    return std::any_of(touched.begin(), touched.end(), [node](const auto& contact) { return contact.node == node; });
  };
  ASSERT_TRUE(stack.Until(5000, [&] { return touches(nodes[0].node); }));
  EXPECT_NEAR(touched[0].point.y, kBaseInLocal.position.y + 0.050f, 2e-3f);
  EXPECT_NEAR(touched[0].normal.y, 1, 0.05f);
  EXPECT_GT(touched[0].penetration, 0);

  // The clay is pressed in by a step: its vertices say so.
  const auto get_mesh = stack.Get<PFN_xrGetHapticNodeMeshOMNIX1>("xrGetHapticNodeMeshOMNIX1");
  const XrHapticNodeMeshGetInfoOMNIX1 of_clay{XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1, nullptr, nodes[0].node};
  XrVector3f vertices[64];
  std::uint32_t indices[256];
  XrHapticNodeMeshOMNIX1 mesh{XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
  ASSERT_TRUE(stack.Until(15'000, [&] {
    mesh = {XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
    mesh.vertexCapacityInput = 64;
    mesh.vertices = vertices;
    mesh.indexCapacityInput = 256;
    mesh.indices = indices;
    return get_mesh(scene, &of_clay, &mesh) == XR_SUCCESS && mesh.maxDisplacement > 0.5e-3f;
  }));
  ASSERT_EQ(mesh.vertexCountOutput, 8U);
  ASSERT_EQ(mesh.indexCountOutput, 36U);
  float top = 0;
  for (const XrVector3f& v : vertices) top = std::max(top, &v < vertices + 8 ? v.y : 0);
  EXPECT_LT(top, 0.0497f) << "of the document's 50 mm";
  std::printf("[ figure   ] top of the clay in the application: %.2f mm of 50\n", 1e3 * static_cast<double>(top));

  // The lid is moved from the side to under the pen, frame by frame.
  const auto move = stack.Get<PFN_xrUpdateHapticNodesOMNIX1>("xrUpdateHapticNodesOMNIX1");
  XrHapticNodePoseOMNIX1 pose{
      nodes[1].node, XR_HAPTIC_NODE_POSE_TELEPORT_BIT_OMNIX1, nodes[1].restPose, {0, 0, 0}, {0, 0, 0}};
  XrTime start = 0;
  EXPECT_TRUE(stack.Until(5000, [&] {
    if (start == 0) start = stack.time;
    const double t = std::min(1.0, 1e-9 * static_cast<double>(stack.time - start));
    pose.pose.position = {static_cast<float>(0.03 * (1 - t)), -0.252f, 0};  // top at 53 mm
    pose.linearVelocity = {t < 1 ? -0.03f : 0, 0, 0};
    const XrHapticNodesUpdateInfoOMNIX1 info{
        XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1, nullptr, XR_NULL_HANDLE, stack.time, 1, &pose};
    EXPECT_EQ(move(scene, &info), XR_SUCCESS);
    pose.flags = 0;
    return t >= 1 && touches(nodes[1].node);
  }));
  EXPECT_EQ(stack.Get<PFN_xrDestroyHapticSceneOMNIX1>("xrDestroyHapticSceneOMNIX1")(scene), XR_SUCCESS);
}

}  // namespace
}  // namespace omni::test
