// omni scene edits, undo, redo, save: what is printed, and files that appear whole or not at all.
#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "service/tools/scene/scene.h"
#include "service/tools/status/status.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_scene_edit {

namespace fs = std::filesystem;
using nlohmann::json;
using test::TempFolder;

std::string ContentOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::size_t FilesIn(const std::string& folder) {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder), {}));
}

TEST(ToolsWholeFile, ReplacesExistingFileOnlyWithForce) {
  const TempFolder folder;
  const std::string path = folder.Path("a.glb"), first(100'000, 'a'), second = "b";
  ASSERT_TRUE(WriteWholeFile(path, first, false).ok());
  EXPECT_TRUE(ContentOf(path) == first);
  const base::Status refused = WriteWholeFile(path, second, false);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().find("a.glb: already exists"), std::string::npos) << refused.error();
  EXPECT_NE(refused.error().find("--force"), std::string::npos);
  EXPECT_TRUE(ContentOf(path) == first);
  ASSERT_TRUE(WriteWholeFile(path, second, true).ok());
  EXPECT_EQ(ContentOf(path), second);
  EXPECT_EQ(FilesIn(folder.Path()), 1U) << "nothing unfinished stays";
  struct stat status {};
  ASSERT_EQ(::stat(path.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0600U, 0600U);
}

TEST(ToolsWholeFile, ErrorsNameTheObstacle) {
  const TempFolder folder;
  EXPECT_NE(WriteWholeFile(folder.Path("no/such/a.glb"), "x", false).error().find("another folder"), std::string::npos);
  EXPECT_NE(WriteWholeFile(folder.Path(), "x", true).error().find("is a folder"), std::string::npos);
  ASSERT_EQ(::symlink("nowhere", folder.Path("link").c_str()), 0);
  EXPECT_FALSE(WriteWholeFile(folder.Path("link"), "x", false).ok()) << "also a link into nothing is kept";
  EXPECT_EQ(FilesIn(folder.Path()), 1U);
}

TEST(ToolsSceneEdit, ShowsObjectsAndToleratesMissingFields) {
  const json edits = json::parse(R"({"client": 4, "scene": "/s/clay.glb", "objects": [
    {"object": 0, "name": "clay", "triangles": 1200, "strokes": 3, "undone": 1, "undo_bytes": 45000,
     "page_bytes": 200000, "stroke_open": true}]})");
  const std::string text = EditsText(edits);
  for (const char* part : {"/s/clay.glb (client 4)", "0  clay: 1200 triangles, 3 strokes, 1 undone", "45.0 kB",
                           "200.0 kB", "a stroke is in progress"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << " not in " << text;
  }
  EXPECT_FALSE(EditsText(json::parse(R"({"objects": [3, {}]})")).empty());
}

TEST(ToolsSceneEdit, WithoutServiceExitsWithItsStatusAndRemedy) {
  const TempFolder folder;
  const std::string socket = folder.Path("omnid.sock"), file = folder.Path("out.glb");
  for (const std::vector<const char*>& words :
       {std::vector<const char*>{"omni", "scene", "undo", "--socket", socket.c_str()},
        {"omni", "scene", "save", file.c_str(), "--socket", socket.c_str()}}) {
    testing::internal::CaptureStderr();
    EXPECT_EQ(RunCommandLine(static_cast<int>(words.size()), words.data()), kExitNoService);
    EXPECT_NE(testing::internal::GetCapturedStderr().find("to start it"), std::string::npos);
  }
  EXPECT_FALSE(fs::exists(file));
}

TEST(ToolsSceneEdit, StatusShowsSoftBodyProgress) {
  json status = json::parse(R"({"scene": {"name": "s.glb", "sculpted": 1,
                               "soft_bodies": {"objects": 2, "ready": 1, "failed": 0, "done": 0.437}}})");
  EXPECT_NE(StatusText(status).find("1 of 2 soft bodies ready, 43 %; a simple model is used until then\n"),
            std::string::npos)
      << StatusText(status);
  EXPECT_NE(StatusText(status).find("1 object; see `omni scene edits`"), std::string::npos);
  status["scene"]["soft_bodies"] = {{"objects", 2}, {"ready", 1}, {"failed", 1}, {"done", 1.0}};
  EXPECT_NE(StatusText(status).find("1 of 2 soft bodies ready, 1 failed (see problems)\n"), std::string::npos);
  status["scene"]["soft_bodies"] = nullptr;
  status["scene"]["sculpted"] = 0;
  EXPECT_EQ(StatusText(status).find("soft"), std::string::npos);
  EXPECT_EQ(StatusText(status).find("sculpted"), std::string::npos);
  EXPECT_EQ(StatusText(status).find("memory"), std::string::npos);
  status["builds"] =
      json::parse(R"({"kept_MB": 410.2, "kept_limit_MB": 768, "building_MB": 0, "building_limit_MB": 1200,
    "builders": [{"file": "b.glb", "soft_body": false, "state": "waits for memory: needs 410 MB, 357 MB are free"}]})");
  const std::string builds = StatusText(status);
  EXPECT_NE(builds.find("scenes keep 411 MB of 768 MB, builders have 0 MB of 1200 MB"), std::string::npos) << builds;
  EXPECT_NE(builds.find("b.glb: waits for memory: needs 410 MB, 357 MB are free"), std::string::npos) << builds;
}

}  // namespace test_tools_scene_edit
}  // namespace omni::tools
