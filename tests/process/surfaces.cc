// A pen that presses a face in: the surface as it is drawn, from the service to a file.
#include <gtest/gtest.h>

#include <chrono>
#include <future>

#include "service/scene/glb_save.h"
#include "service/scene/scene_file.h"
#include "service/tools/surfaces/surfaces.h"
#include "tests/haptics/scenario.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_surfaces {

constexpr const char* kPressAndHold = R"({"name": "press", "repeat": true, "waypoints": [
  {"s": 0, "tip_m": [0, 0, 0.070], "axis": [0, 0, -1]},
  {"s": 0.6, "tip_m": [0, 0, 0.050], "axis": [0, 0, -1]},
  {"s": 1.0, "tip_m": [0, 0, 0.046], "axis": [0, 0, -1]},
  {"s": 0.6, "tip_m": [0, 0, 0.070], "axis": [0, 0, -1]}]})";

// A pad with its top at 56 mm, all of which can be pushed in and pulled out.
std::string PadFile(const TempFolder& folder) {
  haptics::Material clay;
  clay.extrude.enabled = true;
  clay.extrude.grab_force_N = 0.15;
  clay.extrude.dwell_s = 0.1;
  haptics::InputObject pad = haptics::Block(6, {0.02, 0.02, 0.007});
  for (base::Vec3& v : pad.vertices_base_m) v.z += 0.049;
  pad.name = "pad";
  const std::string path = folder.Path("pad.glb");
  EXPECT_TRUE(scene::SaveGlb(path, haptics::SceneOf(pad, clay)).ok());
  return path;
}

TEST(ProcessSurfaces, PublishedSurfacesCanBeSaved) {
  const TempFolder folder;
  ServiceProcess service(PadFile(folder), kPressAndHold);
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus()) << app.connection().last_error();
  const auto saved = [&](tools::SurfacesSaveArguments arguments) {
    arguments.socket = service.socket_path();
    testing::internal::CaptureStdout();
    testing::internal::CaptureStderr();
    const int status = tools::SaveSurfaces(arguments);
    (void)testing::internal::GetCapturedStdout();
    (void)testing::internal::GetCapturedStderr();
    return status == 0;
  };
  const std::string now = folder.Path("now.glb"), largest = folder.Path("largest.glb");
  ASSERT_TRUE(app.Run(10'000, 20, [&] { return saved({.file = now}); }));
  scene::LoadReport report;
  const auto loaded = scene::LoadSceneFile(now, {}, report);
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  ASSERT_EQ(loaded->objects.size(), 1U);
  EXPECT_EQ(loaded->objects[0].name, "pad");
  EXPECT_FALSE(saved({.file = now})) << "it is there already";
  EXPECT_TRUE(saved({.file = now, .force = true}));
  // Runs beside the application, which keeps sending heartbeats: otherwise there is no force and nothing is pressed in.
  std::future<bool> watching =
      std::async(std::launch::async, [&] { return saved({.file = largest, .largest = true, .seconds = 6}); });
  ASSERT_TRUE(
      app.Run(20'000, 10, [&] { return watching.wait_for(std::chrono::seconds(0)) == std::future_status::ready; }));
  EXPECT_TRUE(watching.get()) << "a face was pressed in";
  EXPECT_TRUE(scene::LoadSceneFile(largest, {}, report).ok());
}

}  // namespace test_process_surfaces
}  // namespace omni::test
