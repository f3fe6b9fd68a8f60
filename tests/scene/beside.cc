// Files beside a document: those in its folder and in folders beneath it, and no others.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "service/scene/gltf/file_bytes.h"
#include "service/scene/gltf/json_reading.h"
#include "tests/scene/files.h"

namespace omni::scene::test {
namespace test_scene_beside {

namespace fs = std::filesystem;

Loaded LoadNaming(const TempFolder& folder, const std::string& uri) {
  Model model = Tetra();
  model.json["buffers"][0]["uri"] = uri;
  return Load(folder.Write("model.gltf", model.json.dump()));
}

TEST(SceneBeside, BuffersInFoldersBeneathTheDocumentAreRead) {
  const TempFolder folder;
  fs::create_directories(folder.Path("sub/a b/..c"));
  folder.Write("sub/data.bin", Tetra().bin);
  folder.Write("sub/a b/..c/data.bin", Tetra().bin);
  for (const char* uri : {"sub/data.bin", "./sub/data.bin", "sub/./data.bin", "sub%2Fdata.bin",
                          "sub/a%20b/..c/data.bin", "././sub/a b/./..c/data.bin"}) {
    Loaded loaded = LoadNaming(folder, uri);
    ASSERT_TRUE(loaded.result.ok()) << uri << ": " << loaded.result.error();
    EXPECT_NEAR(SignedVolume6(loaded.scene().objects[0]), 1e-6, 1e-12);
  }
}

TEST(SceneBeside, PathsThatCouldLeadElsewhereAreRefused) {
  const TempFolder folder;
  fs::create_directories(folder.Path("scene/sub"));
  folder.Write("data.bin", Tetra().bin);
  folder.Write("scene/data.bin", Tetra().bin);
  for (const std::string& uri : std::vector<std::string>{"../data.bin",
                                                         "sub/../data.bin",
                                                         "sub/../../data.bin",
                                                         "sub/..",
                                                         "..",
                                                         ".",
                                                         "./",
                                                         "/etc/passwd",
                                                         "//data.bin",
                                                         "sub//data.bin",
                                                         "sub/",
                                                         "sub\\data.bin",
                                                         "..\\data.bin",
                                                         "%2e%2e/data.bin",
                                                         "sub/%2e%2e/data.bin",
                                                         "%2E%2E%2Fdata.bin",
                                                         "%5c%5chost%5cdata.bin",
                                                         "file:data.bin",
                                                         "C:/data.bin",
                                                         "sub/x%00.bin",
                                                         "a/" + std::string(1100, 'x')}) {
    Model model = Tetra();
    model.json["buffers"][0]["uri"] = uri;
    const Loaded loaded = Load(folder.Write("scene/model.gltf", model.json.dump()));
    ASSERT_FALSE(loaded.result.ok()) << uri;
    EXPECT_NE(
        loaded.result.error().find("/buffers/0/uri: names \"" + Printable(uri.substr(0, 60)) + "\"; only files in"),
        std::string::npos)
        << loaded.result.error();
  }
}

// Neither out of the folder nor within it.
TEST(SceneBeside, LinksOnTheWayAreNotFollowed) {
  const TempFolder folder, elsewhere;
  elsewhere.Write("data.bin", Tetra().bin);
  fs::create_directories(folder.Path("sub"));
  folder.Write("sub/data.bin", Tetra().bin);
  fs::create_directory_symlink(elsewhere.Path(), folder.Path("out"));
  fs::create_directory_symlink("sub", folder.Path("in"));
  fs::create_directory_symlink("..", folder.Path("sub/up"));
  fs::create_symlink(elsewhere.Path("data.bin"), folder.Path("sub/link.bin"));
  for (const char* uri : {"out/data.bin", "in/data.bin", "sub/up/sub/data.bin", "sub/link.bin"}) {
    const Loaded loaded = LoadNaming(folder, uri);
    ASSERT_FALSE(loaded.result.ok()) << uri;
    EXPECT_NE(loaded.result.error().find("is a link, which is not followed"), std::string::npos)
        << loaded.result.error();
  }
  // The document itself may be reached through links.
  fs::create_directory_symlink(folder.Path(), elsewhere.Path("models"));
  LoadNaming(folder, "sub/data.bin");
  Loaded loaded = Load(elsewhere.Path("models/model.gltf"));
  EXPECT_TRUE(loaded.result.ok()) << loaded.result.error();
}

TEST(SceneBeside, WhatIsNoFileIsRefused) {
  const TempFolder folder;
  fs::create_directories(folder.Path("sub/folder"));
  folder.Write("sub/file", "x");
  ASSERT_EQ(mkfifo(folder.Path("sub/fifo").c_str(), 0600), 0);
  const auto expect = [&](const char* uri, const char* part) {
    const Loaded loaded = LoadNaming(folder, uri);
    ASSERT_FALSE(loaded.result.ok()) << uri;
    EXPECT_NE(loaded.result.error().find(part), std::string::npos) << loaded.result.error();
  };
  expect("sub/missing.bin", "cannot be opened (No such file or directory)");
  expect("missing/data.bin", "cannot be opened (No such file or directory)");
  expect("sub/file/data.bin", "cannot be opened (Not a directory)");
  expect("sub/folder", "is not a regular file");
  expect("sub/fifo", "is not a regular file");
}

TEST(SceneBeside, TheOpenerChecksPathsItself) {
  const TempFolder folder;
  fs::create_directories(folder.Path("sub"));
  folder.Write("data.bin", "x");
  FilesInFolder files(folder.Path("sub"));
  for (const char* path : {"../data.bin", "/etc/passwd", "", ".", "..", "./../data.bin"})
    EXPECT_THROW((void)files.OpenBeside(path), LoadError) << path;
}

TEST(SceneBeside, ImagesInFoldersAreRead) {
  const TempFolder folder;
  fs::create_directories(folder.Path("textures"));
  folder.Write("textures/clay.png", "no image, but read");
  Model model = Tetra();
  model.json["images"] = Json::array({{{"uri", "textures/clay.png"}}});
  model.json["textures"] = Json::array({{{"source", 0}}});
  const std::size_t uv =
      AddAccessor(model, std::string(32, '\0'), {{"componentType", 5126}, {"count", 4}, {"type", "VEC2"}});
  model.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uv;
  model.json["extensions"]["MPEG_haptic_material"] =
      Json::parse(R"({"materials": [{"friction": [{"texture": {"index": 0}}]}]})");
  model.json["meshes"][0]["extensions"]["MPEG_haptic_material"]["hapticMaterialIndex"] = 0;
  model.json["buffers"][0]["uri"] = "data.bin";
  folder.Write("data.bin", model.bin);
  const Loaded loaded = Load(folder.Write("model.gltf", model.json.dump()));
  ASSERT_TRUE(loaded.result.ok()) << loaded.result.error();
  EXPECT_NE(loaded.Warnings().find("is neither PNG nor JPEG"), std::string::npos) << loaded.Warnings();
}

}  // namespace test_scene_beside
}  // namespace omni::scene::test
