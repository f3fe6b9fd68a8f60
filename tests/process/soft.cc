// A soft body in the service: the scene is there at once, the body follows, and the next service finds it on disk.
#include <gtest/gtest.h>

#include <filesystem>

#include <nlohmann/json.hpp>

#include "service/base/sanitized.h"
#include "service/scene/glb_save.h"
#include "service/tools/common/service_link.h"
#include "tests/haptics/scenario.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_soft {

constexpr const char* kAway = R"({"name": "away", "repeat": false, "waypoints": [
  {"s": 0, "tip_m": [0, 0, 0.085], "axis": [0, 0, -1]}, {"s": 60, "tip_m": [0, 0, 0.085], "axis": [0, 0, -1]}]})";

// To compute the body takes four seconds, beside a tick every millisecond; ThreadSanitizer slows both.
constexpr int kComputing_ms = base::kSanitized ? 600'000 : 120'000;

std::string BallFile(const TempFolder& folder) {
  haptics::Material jelly;
  jelly.softness.model = haptics::SoftnessModel::kTet;
  haptics::InputObject ball = haptics::Sphere(8, 0.01);
  for (base::Vec3& v : ball.vertices_base_m) v.z += 0.055;
  const std::string path = folder.Path("ball.glb");
  EXPECT_TRUE(scene::SaveGlb(path, haptics::SceneOf(ball, jelly)).ok());
  return path;
}

TEST(ProcessSoft, SoftBodyIsComputedAfterSceneLoadAndCached) {
  const TempFolder folder;
  ServiceProcess service(BallFile(folder), kAway);
  bool seen_unfinished = false;
  const auto ready_within = [&](int ms) {
    TestApplication app(service);
    EXPECT_TRUE(app.Focus()) << app.connection().last_error();
    return app.Run(ms, 20, [&] {
      const auto status = tools::FetchStatus(service.socket_path());
      if (!status.ok() || !(*status)["scene"]["soft_bodies"].is_object()) return false;
      const nlohmann::json& soft = (*status)["scene"]["soft_bodies"];
      EXPECT_EQ(soft["objects"], 1);
      EXPECT_EQ(soft["failed"], 0);
      EXPECT_TRUE(soft["done"] >= 0 && soft["done"] <= 1) << soft;
      seen_unfinished = seen_unfinished || soft["ready"] == 0;
      return soft["ready"] == 1;
    });
  };
  service.Start();
  EXPECT_TRUE(ready_within(kComputing_ms));
  EXPECT_TRUE(seen_unfinished) << "it was a layer meanwhile";
  EXPECT_EQ(service.Stop(), 0);
  std::size_t kept = 0;
  for (const auto& entry : std::filesystem::directory_iterator(service.cache_folder())) {
    kept += entry.path().filename().string().starts_with("soft-");
  }
  EXPECT_EQ(kept, 1U);
  service.Start();
  EXPECT_TRUE(ready_within(20'000)) << "from the cache";
}

// A service that is to end does not finish computing first.
TEST(ProcessSoft, ServiceExitsWhileComputingSoftBody) {
  const TempFolder folder;
  ServiceProcess service(BallFile(folder), kAway);
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus());
  ASSERT_TRUE(app.Run(20'000, 10, [&] {
    const auto status = tools::FetchStatus(service.socket_path());
    return status.ok() && (*status)["scene"]["soft_bodies"].is_object();
  }));
  EXPECT_EQ(service.Stop(), 0);
}

}  // namespace test_process_soft
}  // namespace omni::test
