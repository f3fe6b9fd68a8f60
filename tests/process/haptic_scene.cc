// An application that sends its own scene to a real omnid on the twin: rendered, moved, changed, read back, and removed
// with it.
#include <gtest/gtest.h>

#include <fcntl.h>
#include <sys/mman.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "service/base/sanitized.h"
#include "service/base/sealed_memory.h"
#include "tests/support/box_document.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_haptic_scene {

using Json = nlohmann::json;

// Down to 46 mm over the centre and held there, once from outside again: a scene that appears around the tip acts then.
constexpr const char* kPressAndStay = R"({"name": "press", "repeat": false, "waypoints": [
  {"s": 0, "tip_m": [0, 0, 0.070], "axis": [0, 0, -1]},
  {"s": 0.5, "tip_m": [0, 0, 0.046], "axis": [0, 0, -1]}, {"s": 1.5, "tip_m": [0, 0, 0.046], "axis": [0, 0, -1]},
  {"s": 0.3, "tip_m": [0, 0, 0.070], "axis": [0, 0, -1]}, {"s": 0.3, "tip_m": [0, 0, 0.046], "axis": [0, 0, -1]},
  {"s": 120, "tip_m": [0, 0, 0.046], "axis": [0, 0, -1]}]})";

// Under a sanitizer ticks are late and the press is not at its full: the difference has to be larger to be felt.
constexpr double kSofter_N_m = base::kSanitized ? 30 : 60;

// The plate that is pressed, and a lid beside it that moves.
std::string PlateAndLid() {
  return Document(
      {{"plate", 0.02, 0.042, 0.050, {{"stiffness", 300}, {"staticFriction", 0.2}, {"dynamicFriction", 0.2}}},
       {"lid", 0.01, 0.300, 0.305, {{"stiffness", 300}, {"kinematic", true}}}});
}

class SceneApplication : public TestApplication {
 public:
  SceneApplication(const ServiceProcess& service, const std::string& name) : TestApplication(service, name) {}

  // False: it was not sent.
  bool Load(const std::string& document, std::uint32_t flags = 0) {
    const auto fd = base::SealedCopy("test-scene", document);
    if (!fd.ok()) return false;
    protocol::HapticSceneLoad load;
    load.number = ++number;
    load.bytes = document.size();
    load.flags = flags;
    state = {};
    return connection().Send(load, fd->get());
  }

  void Take() {
    for (client::HapticSceneUpdate& update : connection().PopHapticSceneUpdates()) {
      if (update.is_table) table = update.table;
      if (!update.is_table && update.state.number == number) {
        state = update.state;
        text = update.text;
      }
    }
  }

  bool WaitStatus(protocol::HapticSceneStatus status, int ms = 20'000) {
    return Run(ms, 2, [&] {
      Take();
      return state.status == status;
    });
  }

  protocol::ContactSnapshot Contacts() {
    protocol::ContactSnapshot contacts;
    const auto reader = connection().state();
    if (reader != nullptr) reader->ReadContacts(contacts);
    return contacts;
  }
  bool Touches(std::uint32_t object) {
    Take();
    const protocol::ContactSnapshot contacts = Contacts();
    if (contacts.scene_generation != state.generation || state.generation == 0) return false;
    return std::any_of(contacts.contacts.begin(), contacts.contacts.begin() + contacts.count,
                       [object](const protocol::ContactSample& contact) { return contact.object == object; });
  }

  std::uint32_t number = 0;
  protocol::HapticSceneState state;
  std::string text;
  client::HapticSceneTable table;
};

double Milliseconds(std::int64_t since_ns) { return 1e-6 * static_cast<double>(base::MonotonicNow_ns() - since_ns); }

TEST(ProcessHapticScene, CanBeLoadedChangedMovedDisabledAndEnded) {
  const TempFolder folder;
  ServiceProcess service(folder.Path("none.glb"), kPressAndStay);
  service.Start();
  SceneApplication app(service, "haptic_scene");  // no entry of apps.d is for it
  ASSERT_TRUE(app.Focus()) << app.connection().last_error();
  app.Run(300, 5);
  EXPECT_LT(app.Force_N(), 0.01) << "nothing is there yet";

  ASSERT_TRUE(app.Load(PlateAndLid()));
  ASSERT_TRUE(app.WaitStatus(protocol::HapticSceneStatus::kReady)) << app.text;
  std::printf("[ figure   ] scene from memory: ready after %.1f ms\n", 1e-6 * static_cast<double>(app.state.load_ns));
  ASSERT_EQ(app.table.nodes.size(), 2U);
  EXPECT_EQ(std::string(app.table.nodes[0].name), "plate");
  EXPECT_EQ(app.table.nodes[1].gltf_node, 1);
  EXPECT_EQ(app.table.nodes[0].flags & protocol::kNodeKinematic, 0U);
  EXPECT_NE(app.table.nodes[1].flags & protocol::kNodeKinematic, 0U);
  ASSERT_TRUE(app.Run(5000, 5, [&] { return app.Touches(0); }));
  ASSERT_TRUE(app.WaitForForce(0.3));
  app.Run(500, 5);  // the gate and the press are at their full
  const protocol::ContactSnapshot pressed = app.Contacts();
  ASSERT_GE(pressed.count, 1U);
  EXPECT_NEAR(pressed.contacts[0].point_base_m[2], 0.050, 1e-3);
  EXPECT_NEAR(pressed.contacts[0].normal_base[2], 1, 1e-2);
  EXPECT_GT(pressed.contacts[0].penetration_m, 1e-4);
  EXPECT_NEAR(pressed.contacts[0].normal_force_N, pressed.contacts[0].force_base_N[2],
              0.2 * pressed.contacts[0].normal_force_N);

  // A softer material: the same press produces less force.
  const double before_N = app.Force_N();
  protocol::HapticMaterial softer;
  softer.number = app.number;
  softer.material = app.table.nodes[0].material;
  softer.parameters = app.table.materials[softer.material];
  softer.parameters.stiffness_N_m = kSofter_N_m;
  ASSERT_TRUE(app.connection().Send(softer));
  EXPECT_TRUE(app.Run(3000, 5, [&] { return app.Force_N() < 0.6 * before_N; })) << app.Force_N() << " of " << before_N;
  std::printf("[ figure   ] stiffness 300 -> %.0f N/m while pressed: %.3f -> %.3f N\n", kSofter_N_m, before_N,
              app.Force_N());
  softer.parameters.stiffness_N_m = 300;
  ASSERT_TRUE(app.connection().Send(softer));
  ASSERT_TRUE(app.WaitForForce(0.8 * before_N));

  // The lid comes from above the plate's side to under the pen, 30 mm in 0.6 s, sent 90 times a second.
  protocol::HapticNodes lid;
  lid.number = app.number;
  lid.count = 1;
  lid.nodes[0].object = 1;
  const auto hold_lid = [&](double x_m, double speed_m_s, bool leaps) {
    lid.t_ns = base::MonotonicNow_ns() + 10'000'000;
    lid.nodes[0].flags = leaps ? protocol::kPoseLeaps : 0U;
    lid.nodes[0].pose.position_m = {x_m, 0, -0.252};  // top at 53 mm
    lid.nodes[0].pose.velocity_m_s = {speed_m_s, 0, 0};
    app.connection().Send(lid);
  };
  hold_lid(0.030, 0, true);
  app.Run(100, 11);
  EXPECT_FALSE(app.Touches(1));
  for (int k = 0; k <= 54 && !app.Touches(1); ++k) {
    hold_lid(0.030 * (1 - k / 54.0), -0.05, false);
    app.Run(11, 2);
  }
  EXPECT_TRUE(app.Run(1000, 5, [&] { return app.Touches(1); })) << "the lid is under the pen, or the pen in it";

  // Moved 80 mm away, the scene produces no force; moved back it does again.
  protocol::HapticScenePlace place;
  place.number = app.number;
  place.t_ns = base::MonotonicNow_ns();
  place.pose.position_m = {0.080, 0, 0};
  ASSERT_TRUE(app.connection().Send(place));
  EXPECT_TRUE(app.Run(2000, 2, [&] { return app.Contacts().count == 0 && app.Force_N() < 0.01; }));
  place.t_ns = base::MonotonicNow_ns();
  place.pose.position_m = {};
  ASSERT_TRUE(app.connection().Send(place));
  EXPECT_TRUE(app.Run(3000, 2, [&] { return app.Touches(0) || app.Touches(1); }));

  // Disabled: no force. Enabled: force again. Ended: no force for good.
  protocol::HapticSceneEnable enable;
  enable.number = app.number;
  ASSERT_TRUE(app.connection().Send(enable));
  EXPECT_TRUE(app.Run(2000, 2, [&] {
    app.Take();
    return app.state.generation == 0 && app.Force_N() < 0.01;
  }));
  enable.enabled = 1;
  ASSERT_TRUE(app.connection().Send(enable));
  EXPECT_TRUE(app.WaitForForce(0.2));
  protocol::HapticSceneEnd end;
  end.number = app.number;
  ASSERT_TRUE(app.connection().Send(end));
  EXPECT_TRUE(app.Run(2000, 2, [&] { return app.Contacts().count == 0 && app.Force_N() < 0.01; }));
}

TEST(ProcessHapticScene, RejectsBadDocumentsWithJsonPointer) {
  const TempFolder folder;
  ServiceProcess service(folder.Path("none.glb"), kPressAndStay);
  service.Start();
  SceneApplication app(service, "bad_scenes");
  ASSERT_TRUE(app.Focus()) << app.connection().last_error();
  Json cut = Json::parse(R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 36, "uri": "beside.bin"}],
    "bufferViews": [{"buffer": 0, "byteLength": 36}], "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3,
    "type": "VEC3"}], "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}], "nodes": [{"mesh": 0}],
    "scenes": [{"nodes": [0]}], "scene": 0})");
  Json cycle = Json::parse(R"({"asset": {"version": "2.0"}, "nodes": [{"children": [1]}, {"children": [0]}],
    "scenes": [{"nodes": [0]}], "scene": 0})");
  struct Bad {
    std::string document, said;
  };
  const std::string good = PlateAndLid();
  std::string flipped = good;
  for (std::size_t i = 200; i < 400; i += 7) flipped[i] = static_cast<char>(flipped[i] ^ 0x15);
  double slowest_ms = 0;
  for (const Bad& bad : {Bad{"nonsense", "neither binary glTF"}, Bad{good.substr(0, 300), "truncated"},
                         Bad{R"({"asset": {"version": "1.0"}})", "/asset/version"}, Bad{cut.dump(), "/buffers/0/uri"},
                         Bad{cycle.dump(), "/nodes/"}, Bad{flipped, ""}, Bad{std::string(1, '\0'), ""}}) {
    const std::int64_t start_ns = base::MonotonicNow_ns();
    ASSERT_TRUE(app.Load(bad.document, protocol::kSceneTouchUntagged));
    ASSERT_TRUE(app.WaitStatus(protocol::HapticSceneStatus::kFailed, 5000)) << bad.said;
    slowest_ms = std::max(slowest_ms, Milliseconds(start_ns));
    EXPECT_NE(app.text.find(bad.said), std::string::npos) << app.text;
    EXPECT_FALSE(app.text.empty());
  }
  std::printf("[ figure   ] bad documents: refused within %.1f ms\n", slowest_ms);
  // The connection has survived, and a valid document works.
  ASSERT_TRUE(app.Load(good));
  EXPECT_TRUE(app.WaitStatus(protocol::HapticSceneStatus::kReady)) << app.text;
}

TEST(ProcessHapticScene, FocusSwitchesScenesAndExitFreesThem) {
  const TempFolder folder;
  ServiceProcess service(folder.Path("none.glb"), kPressAndStay);
  service.Start();
  SceneApplication first(service, "first_scene");
  ASSERT_TRUE(first.Focus()) << first.connection().last_error();
  // So thick that the upper face stays the nearest one of a pen that sinks while scenes change on a slow computer.
  ASSERT_TRUE(first.Load(Document({{"high", 0.02, 0.030, 0.050, {{"stiffness", 300}}}})));
  ASSERT_TRUE(first.WaitStatus(protocol::HapticSceneStatus::kReady)) << first.text;
  ASSERT_TRUE(first.WaitForForce(0.2));
  {
    SceneApplication second(service, "second_scene");
    ASSERT_TRUE(second.Focus()) << second.connection().last_error();
    ASSERT_TRUE(second.Load(Document({{"higher", 0.02, 0.030, 0.052, {{"stiffness", 300}}}})));
    ASSERT_TRUE(second.WaitStatus(protocol::HapticSceneStatus::kReady)) << second.text;
    ASSERT_TRUE(second.Run(3000, 5, [&] {
      first.connection().Poll(base::MonotonicNow_ns());
      first.connection().SignalAlive();
      first.Take();
      return second.Touches(0) && first.state.generation == 0;
    }));
    EXPECT_NEAR(second.Contacts().contacts[0].point_base_m[2], 0.052, 1e-3);
    EXPECT_FALSE(first.Touches(0)) << "what is touched is the other's";
  }
  // The second one is gone, its scene with it.
  EXPECT_TRUE(first.Run(3000, 5, [&] { return first.Touches(0); }));
  EXPECT_NEAR(first.Contacts().contacts[0].point_base_m[2], 0.050, 1e-3);
}

// Clay whose face is pressed in by a step: its vertices arrive in the application.
TEST(ProcessHapticScene, DeformedVerticesComeBack) {
  const TempFolder folder;
  ServiceProcess service(folder.Path("none.glb"), kPressThenDeeper);
  service.Start();
  SceneApplication app(service, "soft_scene");
  ASSERT_TRUE(app.Focus()) << app.connection().last_error();
  const Json soft = {
      {"stiffness", 300},
      {"extrude", {{"step", 0.004}, {"stepsIn", 1}, {"stepsOut", 0}, {"grabForce", 0.1}, {"dwell", 0.1}}}};
  ASSERT_TRUE(app.Load(Document({{"clay", 0.02, 0.040, 0.050, soft}})));
  ASSERT_TRUE(app.WaitStatus(protocol::HapticSceneStatus::kReady)) << app.text;
  ASSERT_NE(app.table.nodes.at(0).flags & protocol::kNodeExtrudable, 0U) << app.text;
  ASSERT_TRUE(app.connection().RequestSurfaces(true));
  client::SurfaceCopy copy;
  EXPECT_TRUE(app.Run(40'000, 5, [&] {
    app.Take();
    const auto surfaces = app.connection().surfaces();
    if (surfaces == nullptr || surfaces->scene_generation() != app.state.generation) return false;
    return surfaces->Read(0, copy) != client::SurfaceRead::kNothing && copy.frame.largest_displacement_m > 1e-3;
  }));
  EXPECT_EQ(copy.vertices_base_m.size(), 8U);
  std::printf("[ figure   ] deformed vertices out: %zu, largest displacement %.2f mm\n", copy.vertices_base_m.size(),
              1e3 * copy.frame.largest_displacement_m);
}

}  // namespace test_process_haptic_scene
}  // namespace omni::test
