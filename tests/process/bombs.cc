// Malicious files: the service rejects them and keeps running.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/support/bombs.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_process_bombs {

// A file of the user's settings.
void WriteSettings(const ServiceProcess& service, const std::string& name, const std::string& text) {
  const auto file = std::filesystem::path(service.hand_path()).parent_path() / "config/omni" / name;
  std::filesystem::create_directories(file.parent_path());
  std::ofstream(file) << text;
}

TEST(ProcessBombs, RejectsTooDeeplyNestedSettingsAndKeepsOthers) {
  std::string key = "a";
  while (key.size() < 80'000) key += ".a";
  ServiceProcess service;
  for (const char* name : {"apps.d/bomb.toml", "inputs.toml", "alignments.toml", "magnets.toml", "calibration.toml"})
    WriteSettings(service, name, key + " = 1\n");
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus()) << app.connection().last_error();
  EXPECT_TRUE(app.WaitForForce(0.1)) << "the scene of its own entry";
}

// Another application keeps its force meanwhile and afterwards.
TEST(ProcessBombs, RejectsEachMaliciousSceneAndKeepsServing) {
  const TempFolder folder;
  ServiceProcess service;
  for (std::size_t i = 0; i < kSceneBombs.size(); ++i) {
    const std::string name = "bomb-" + std::to_string(i);
    const std::string scene = folder.Write(name + ".gltf", kSceneBombs[i].make(300'000));
    WriteSettings(service, "apps.d/" + name + ".toml",
                  "application = \"" + name + "\"\nscene = \"" + scene + "\"\ntouch = \"all\"\n");
  }
  service.Start();
  TestApplication app(service);
  ASSERT_TRUE(app.Focus()) << app.connection().last_error();
  ASSERT_TRUE(app.WaitForForce(0.1));
  for (std::size_t i = 0; i < kSceneBombs.size(); ++i) {
    TestApplication bomb(service, "bomb-" + std::to_string(i));
    ASSERT_TRUE(bomb.Run(5000, 5, [&] { return bomb.connection().connected(); })) << kSceneBombs[i].name;
    ASSERT_TRUE(bomb.connection().SendSession(protocol::SessionState::kBegun));
    // A few are valid glTF: they load without any notice.
    bomb.Run(3000, 5, [&] {
      app.connection().Poll(base::MonotonicNow_ns());
      app.connection().SignalAlive();
      return !bomb.connection().PopNotices().empty();
    });
    ASSERT_TRUE(bomb.connection().connected()) << kSceneBombs[i].name;
  }
  EXPECT_TRUE(app.WaitForForce(0.1)) << "still felt";
  // The builder is free: the next scene is there at once.
  TestApplication next(service);
  ASSERT_TRUE(next.Focus());
  EXPECT_TRUE(next.WaitForForce(0.1));
}

}  // namespace test_process_bombs
}  // namespace omni::test
