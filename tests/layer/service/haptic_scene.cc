// An application's scene end to end: an OpenXR application, the loader, the layer, omnid, the twin. It is placed,
// touched, moved and read back; it ends with its application, and so does the force.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <string>
#include <system_error>
#include <vector>

#include "layer/src/spaces/locate.h"
#include "tests/layer/service/child_app.h"
#include "tests/layer/support/scene_functions.h"
#include "tests/support/box_document.h"

namespace omni::test {
namespace test_service_haptic_scene {

// Pressed 8 mm into a block with its top at 50 mm, for five seconds again and again: a block that appears around the
// tip acts when it comes from outside.
constexpr const char* kPressed = R"({"name": "pressed", "repeat": true, "waypoints": [
  {"s": 0.5, "tip_m": [0, 0, 0.070], "axis": [0, 0, -1]}, {"s": 0.5, "tip_m": [0, 0, 0.042], "axis": [0, 0, -1]},
  {"s": 5, "tip_m": [0, 0, 0.042], "axis": [0, 0, -1]}, {"s": 0.5, "tip_m": [0, 0, 0.070], "axis": [0, 0, -1]}]})";

// An application's own scene, one at a time.
class SceneApp {
 public:
  SceneApp() : app(Options()), f(app.instance), local(app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_LOCAL)) {}

  // Frame after frame until `done`; false: timed out.
  bool Until(const std::function<bool()>& done) {
    const std::int64_t end_ns = Now_ns() + 2 * Patience_ns();
    while (Now_ns() < end_ns) {
      app.Poll();
      app.Sync();
      if (each_frame) each_frame();
      XrFrameState frame{XR_TYPE_FRAME_STATE};
      if (xrWaitFrame(app.session, nullptr, &frame) == XR_SUCCESS) {
        time = frame.predictedDisplayTime;
        xrBeginFrame(app.session, nullptr);
        const XrFrameEndInfo end{XR_TYPE_FRAME_END_INFO, nullptr, time, XR_ENVIRONMENT_BLEND_MODE_OPAQUE, 0, nullptr};
        xrEndFrame(app.session, &end);
      }
      if (done()) return true;
    }
    return false;
  }

  // The document's frame stands `up_m` above the base's centre, turned by a quarter about the vertical; placed in
  // `space`, whose axes are LOCAL's.
  bool Give(const std::string& document, double up_m, XrSpace space, float scale = 1) {
    XrHapticSceneCreateInfoOMNIX1 create{XR_TYPE_HAPTIC_SCENE_CREATE_INFO_OMNIX1};
    create.bufferByteCount = static_cast<std::uint32_t>(document.size());
    create.buffer = reinterpret_cast<const std::uint8_t*>(document.data());
    if (f.create(app.session, &create, &scene) != XR_SUCCESS) return false;
    XrSpaceLocation found{XR_TYPE_SPACE_LOCATION};
    if (xrLocateSpace(local, space, Now_ns() + kRuntimeOffset_ns, &found) != XR_SUCCESS) return false;
    const XrVector3f &base = BaseInLocal(), &origin = found.pose.position;
    const XrVector3f at{base.x + origin.x, base.y + origin.y + static_cast<float>(up_m), base.z + origin.z};
    const XrHapticScenePlacementOMNIX1 placement{
        XR_TYPE_HAPTIC_SCENE_PLACEMENT_OMNIX1, nullptr, space, {{0, std::sqrt(0.5f), 0, std::sqrt(0.5f)}, at}, scale};
    return f.place(scene, &placement) == XR_SUCCESS;
  }
  bool UntilFelt() {
    return Until([&] {
      const XrHapticSceneStateOMNIX1 state = State();
      return state.status == XR_HAPTIC_SCENE_STATUS_READY_OMNIX1 && state.isFelt;
    });
  }

  XrHapticSceneStateOMNIX1 State() const {
    XrHapticSceneStateOMNIX1 state{XR_TYPE_HAPTIC_SCENE_STATE_OMNIX1};
    EXPECT_EQ(f.state(scene, &state), XR_SUCCESS);
    return state;
  }

  // By glTF node.
  std::vector<XrHapticSceneNodeOMNIX1> Nodes() const {
    std::uint32_t count = 0;
    EXPECT_EQ(f.nodes(scene, 0, &count, nullptr), XR_SUCCESS);
    std::vector<XrHapticSceneNodeOMNIX1> nodes(count, {XR_TYPE_HAPTIC_SCENE_NODE_OMNIX1});
    EXPECT_EQ(f.nodes(scene, count, &count, nodes.data()), XR_SUCCESS);
    return nodes;
  }

  // What is touched now, in LOCAL.
  std::vector<XrHapticContactOMNIX1> Contacts() const {
    const XrHapticContactsGetInfoOMNIX1 info{XR_TYPE_HAPTIC_CONTACTS_GET_INFO_OMNIX1, nullptr, local, time};
    std::vector<XrHapticContactOMNIX1> contacts(8, {XR_TYPE_HAPTIC_CONTACT_OMNIX1});
    std::uint32_t count = 0;
    if (f.contacts(scene, &info, 8, &count, contacts.data()) != XR_SUCCESS) count = 0;
    contacts.resize(count);
    return contacts;
  }
  bool Touches(XrHapticNodeIdOMNIX1 node) const {
    const auto contacts = Contacts();
    return std::any_of(contacts.begin(), contacts.end(), [node](const auto& contact) { return contact.node == node; });
  }
  // A block under the pen, which may already be in it, until it pushes back.
  bool LoadAndTouchBlock() {
    if (!Give(Document({{"block", 0.02, 0.005, 0.030, {{"stiffness", 300}}}}), 0.020, local)) return false;
    int pressed_frames = 0;  // in a row: the force fades in, and the hand gives way to it
    return Until([&] {
      const auto contacts = Contacts();
      const bool pressed = !contacts.empty() && contacts[0].normalForce > 0.3f;
      pressed_frames = pressed ? pressed_frames + 1 : 0;
      return pressed_frames == 60;
    });
  }
  void LiveOn(int ms) {
    const std::int64_t end_ns = Now_ns() + std::int64_t{ms} * 1'000'000;
    Until([end_ns] { return Now_ns() > end_ns; });
  }

  // Before it is aligned.
  static XrVector3f BaseInLocal() { return layer::ToXr(layer::DefaultBasePose().p); }

  App app;
  SceneFunctions f;
  XrSpace local;
  XrHapticSceneOMNIX1 scene = XR_NULL_HANDLE;
  XrTime time = 0;
  std::function<void()> each_frame;  // besides what a frame loop does

 private:
  static AppOptions Options() {
    AppOptions options;
    options.extensions = kSceneExtensions;
    options.name = "scene stack";
    return options;
  }
};

// A node's mesh as it was read last.
struct ReadMesh {
  XrHapticNodeMeshOMNIX1 mesh{XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
  std::vector<XrVector3f> vertices = std::vector<XrVector3f>(64);
  std::vector<std::uint32_t> indices = std::vector<std::uint32_t>(256);

  bool Read(const SceneApp& app, XrHapticNodeIdOMNIX1 node) {
    const XrHapticNodeMeshGetInfoOMNIX1 info{XR_TYPE_HAPTIC_NODE_MESH_GET_INFO_OMNIX1, nullptr, node};
    mesh = {XR_TYPE_HAPTIC_NODE_MESH_OMNIX1};
    mesh.vertexCapacityInput = static_cast<std::uint32_t>(vertices.size());
    mesh.vertices = vertices.data();
    mesh.indexCapacityInput = static_cast<std::uint32_t>(indices.size());
    mesh.indices = indices.data();
    return app.f.mesh(app.scene, &info, &mesh) == XR_SUCCESS;
  }
  float Top_m() const {
    float top_m = -1;
    for (std::uint32_t i = 0; i < mesh.vertexCountOutput; ++i) top_m = std::max(top_m, vertices[i].y);
    return top_m;
  }
};

// Clay with its top at 30 mm, whose face goes in by one step of 4 mm, and a lid beside it: sizes as rendered at
// `scale`.
std::string ClayAndLid(double scale = 1) {
  return Document(
      {{"clay",
        0.020 / scale,
        0.020 / scale,
        0.030 / scale,
        {{"stiffness", 300}, {"extrude", {{"step", 0.004}, {"stepsOut", 0}, {"grabForce", 0.1}, {"dwell", 0.1}}}}},
       {"lid", 0.010 / scale, 0.300 / scale, 0.305 / scale, {{"stiffness", 300}, {"kinematic", true}}}});
}

TEST(HapticSceneStack, SceneIsPlacedTouchedDeformedMovedAndReadBack) {
  StackService service("none.glb", kPressThenDeeper);
  SceneApp app;
  ASSERT_TRUE(app.Give(ClayAndLid(), 0.020, app.local));
  ASSERT_TRUE(app.UntilFelt());
  EXPECT_TRUE(
      app.Until([&] { return app.app.CountEvents(XR_TYPE_EVENT_DATA_HAPTIC_SCENE_STATE_CHANGED_OMNIX1) == 1; }));
  const auto nodes = app.Nodes();
  ASSERT_EQ(nodes.size(), 2U);
  EXPECT_NE(nodes[0].flags & XR_HAPTIC_NODE_EXTRUDABLE_BIT_OMNIX1, 0U);

  // Touched where it was placed: its top at 50 mm over the base's centre, or one step in.
  std::vector<XrHapticContactOMNIX1> touched;
  ASSERT_TRUE(app.Until([&] { return !(touched = app.Contacts()).empty(); }));
  const XrVector3f base = SceneApp::BaseInLocal();
  EXPECT_EQ(touched[0].node, nodes[0].node);
  EXPECT_GT(touched[0].point.y, base.y + 0.0455f);
  EXPECT_LT(touched[0].point.y, base.y + 0.0505f);
  EXPECT_NEAR(touched[0].point.x, base.x, 3e-3f);
  EXPECT_NEAR(touched[0].normal.y, 1, 0.05f);

  // Deformed: the document's vertices show it.
  ReadMesh clay;
  constexpr float kStep_m = 0.004f;
  ASSERT_TRUE(app.Until([&] { return clay.Read(app, nodes[0].node) && clay.mesh.maxDisplacement > 0.999f * kStep_m; }))
      << "displaced by " << clay.mesh.maxDisplacement << " m";
  EXPECT_EQ(clay.mesh.vertexCountOutput, 8U);
  EXPECT_EQ(clay.mesh.indexCountOutput, 36U);
  EXPECT_NEAR(clay.Top_m(), 0.030f - clay.mesh.maxDisplacement, 1e-5f);
  EXPECT_LE(clay.mesh.maxDisplacement, kStep_m + 1e-6f) << "one step";
  std::printf("[ figure   ] top of the clay in the application: %.2f mm of 30\n",
              1e3 * static_cast<double>(clay.Top_m()));

  // Disabled, it is not rendered and has no shape to read; enabled again, it has its former shape.
  EXPECT_EQ(app.f.enable(app.scene, XR_FALSE), XR_SUCCESS);
  EXPECT_TRUE(app.Until([&] { return !app.State().isFelt && app.Contacts().empty(); }));
  EXPECT_FALSE(clay.Read(app, nodes[0].node));
  EXPECT_EQ(app.f.enable(app.scene, XR_TRUE), XR_SUCCESS);
  EXPECT_TRUE(app.Until([&] { return clay.Read(app, nodes[0].node) && app.Touches(nodes[0].node); }));
  EXPECT_NEAR(clay.mesh.maxDisplacement, kStep_m, 1e-5f) << "as it was left";

  // The lid moves from the side to under the pen, updated frame by frame.
  XrHapticNodePoseOMNIX1 pose{
      nodes[1].node, XR_HAPTIC_NODE_POSE_TELEPORT_BIT_OMNIX1, nodes[1].restPose, {0, 0, 0}, {0, 0, 0}};
  const XrTime start = app.time;
  EXPECT_TRUE(app.Until([&] {
    const double t = std::min(1.0, 1e-9 * static_cast<double>(app.time - start));
    pose.pose.position = {static_cast<float>(0.03 * (1 - t)), -0.272f, 0};  // top at 53 mm over the base's centre
    pose.linearVelocity = {t < 1 ? -0.03f : 0, 0, 0};
    const XrHapticNodesUpdateInfoOMNIX1 info{
        XR_TYPE_HAPTIC_NODES_UPDATE_INFO_OMNIX1, nullptr, XR_NULL_HANDLE, app.time, 1, &pose};
    EXPECT_EQ(app.f.move(app.scene, &info), XR_SUCCESS);
    pose.flags = 0;
    return t >= 1 && app.Touches(nodes[1].node);
  })) << "the lid is under the pen";
  EXPECT_EQ(app.f.destroy(app.scene), XR_SUCCESS);
}

// A space that trembles, as a tracked one does: the placement is sent again in every frame, and the press goes on. The
// document is half as large as rendered.
TEST(HapticSceneStack, SceneIsDeformedInTremblingSpace) {
  StackService service("none.glb", kPressThenDeeper);
  ASSERT_EQ(omni_test_reset(), 0);
  SceneApp app;
  const auto set_head = [&](double s) {  // 0.2 mm up and down, twice a second
    const double w = 2 * std::numbers::pi * 2;
    const float pose[7] = {0, 1.6f + 2e-4f * static_cast<float>(std::sin(w * s)), 0, 0, 0, 0, 1};
    const float velocity[6] = {0, static_cast<float>(2e-4 * w * std::cos(w * s)), 0, 0, 0, 0};
    ASSERT_EQ(omni_test_set_head(pose, velocity), 0);
  };
  set_head(0);
  const XrSpace view = app.app.ReferenceSpace(XR_REFERENCE_SPACE_TYPE_VIEW);
  ASSERT_TRUE(app.Give(ClayAndLid(2), 0.020, view, 2));
  const std::int64_t start_ns = Now_ns();
  app.each_frame = [&] { set_head(1e-9 * static_cast<double>(Now_ns() - start_ns)); };
  ASSERT_TRUE(app.UntilFelt());
  const XrHapticNodeIdOMNIX1 node = app.Nodes()[0].node;
  ReadMesh clay;
  EXPECT_TRUE(app.Until([&] { return clay.Read(app, node) && clay.mesh.maxDisplacement > 0.5e-3f; }))
      << "displaced by " << clay.mesh.maxDisplacement << " m";
  EXPECT_NEAR(clay.Top_m(), 0.015f - clay.mesh.maxDisplacement, 1e-5f)
      << "in the document's frame, which does not move";
  EXPECT_EQ(omni_test_reset(), 0);
}

// The number of application documents that omnid holds: memory objects among its descriptors.
int DocumentsHeldBy(pid_t omnid) {
  int held = 0;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/" + std::to_string(omnid) + "/fd")) {
    std::error_code gone;
    const std::string target = std::filesystem::read_symlink(entry, gone).string();
    if (target.find("memfd:omni-scene") != std::string::npos) ++held;
  }
  return held;
}

TEST(HapticSceneStack, KilledApplicationReleasesItsScene) {
  StackService service("none.glb", kPressed);
  ForkedApp<SceneApp> first([](SceneApp& a) -> std::int64_t { return a.LoadAndTouchBlock() ? Now_ns() : 0; },
                            [](SceneApp& a) { a.Until([] { return false; }); });
  EXPECT_EQ(DocumentsHeldBy(service.pid()), 1);
  const std::int64_t killed_ns = Now_ns();
  first.Kill();
  ASSERT_NE(first.reported(), 0);
  SleepMs(500);
  EXPECT_TRUE(Eventually([&] { return DocumentsHeldBy(service.pid()) == 0; })) << "omnid has forgotten it";
  const std::int64_t next_ns = Now_ns();
  ForkedApp<SceneApp> second([](SceneApp& a) -> std::int64_t { return a.LoadAndTouchBlock() ? Now_ns() : 0; },
                             [](SceneApp&) {});
  second.Kill();
  EXPECT_NE(second.reported(), 0) << "the next application touches a scene of its own";
  const double ms = StopAndPrintTimeToZero_ms(service, "kill -9 of a scene's application", killed_ns,
                                              1e-6 * static_cast<double>(next_ns - killed_ns));
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

TEST(HapticSceneStack, LosingFocusEndsSceneForce) {
  StackService service("none.glb", kPressed);
  ForkedApp<SceneApp> child(
      [](SceneApp& a) -> std::int64_t {
        if (!a.LoadAndTouchBlock()) return 0;
        const std::int64_t t_ns = Now_ns();
        omni_test_set_focus(0);
        return t_ns;
      },
      [](SceneApp& a) { a.LiveOn(600); });
  SleepMs(500);
  child.Kill();
  ASSERT_NE(child.reported(), 0);
  const double ms = StopAndPrintTimeToZero_ms(service, "a scene's application lost focus", child.reported());
  EXPECT_GE(ms, 0);
  EXPECT_LE(ms, 50);
}

// It is stopped, not dead: the force fades (0.25 s to 0.35 s after the last heartbeat, plus clock error).
TEST(HapticSceneStack, ForceFadesWhenApplicationIsStopped) {
  StackService service("none.glb", kPressed);
  ForkedApp<SceneApp> child([](SceneApp& a) -> std::int64_t { return a.LoadAndTouchBlock() ? Now_ns() : 0; },
                            [](SceneApp& a) { a.Until([] { return false; }); });
  const std::int64_t stopped_ns = Now_ns();
  child.Stop();
  SleepMs(900);
  child.Kill();
  ASSERT_NE(child.reported(), 0);
  const double ms = StopAndPrintTimeToZero_ms(service, "a stop of a scene's application", stopped_ns, 850);
  EXPECT_GE(ms, 200) << "it must bear a hitch of the application";
  EXPECT_LE(ms, 450);
}

}  // namespace test_service_haptic_scene
}  // namespace omni::test
