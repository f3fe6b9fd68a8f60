// Application files: globs, precedence, and broken files that do not affect others.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "service/config/files/app_file.h"
#include "service/config/paths.h"
#include "tests/support/process/scoped_variable.h"
#include "tests/support/process/temp_folder.h"

namespace omni::config {
namespace test_config_apps {

std::string Entry(const std::string& glob, const std::string& scene, const std::string& more = {}) {
  return "application = \"" + glob + "\"\nscene = \"" + scene + "\"\n" + more;
}

std::string ErrorOf(const std::string& text) {
  const auto entry = ParseAppFile(text, "test.toml", "/scenes");
  EXPECT_FALSE(entry.ok());
  return entry.ok() ? std::string() : entry.error();
}

void ExpectMentions(const std::string& error, std::initializer_list<const char*> words) {
  for (const char* word : words) EXPECT_NE(error.find(word), std::string::npos) << word << " not in: " << error;
}

TEST(ConfigApps, ShippedFilesGiveEachDemoItsScene) {
  const AppTable table = LoadAppTable({OMNI_SOURCE_DIR "/manifests/apps.d"}, "/scenes");
  EXPECT_TRUE(table.problems.empty()) << table.problems.front();
  const struct {
    const char* application;
    const char* scene;
  } rows[] = {{"omni_touch_extrusion", "/scenes/extrusion.glb"},
              {"omni_touch_dragon_2", "/scenes/dragon.glb"},
              {"omni_touch_racetrack", "/scenes/racetrack.glb"}};
  for (const auto& row : rows) {
    const AppEntry* app = FindApp(table, row.application);
    ASSERT_NE(app, nullptr) << row.application;
    EXPECT_EQ(app->scene, row.scene);
    EXPECT_EQ(app->placement, Placement::kAsAuthored);
  }
  EXPECT_EQ(FindApp(table, "omni_touch"), nullptr);
  EXPECT_EQ(FindApp(table, "some game"), nullptr);
  EXPECT_EQ(FindApp(table, ""), nullptr);
}

TEST(ConfigApps, ReadsEveryKey) {
  const auto entry = ParseAppFile(Entry("My *", "models/cup.glb",
                                        "placement = \"fit\"\noffset_base_m = [0.01, -0.02, 0.03]\nscale = 2\n"
                                        "force_scale = 0.5\n"),
                                  "mine.toml", "/scenes");
  ASSERT_TRUE(entry.ok()) << entry.error();
  EXPECT_EQ(entry->file, "mine.toml");
  EXPECT_EQ(entry->application_glob, "My *");
  EXPECT_EQ(entry->scene, "/scenes/models/cup.glb");
  EXPECT_EQ(entry->placement, Placement::kFit);
  EXPECT_EQ(entry->touch, Touch::kAll) << "fit asks for all of an untagged file";
  EXPECT_EQ(ParseAppFile(Entry("a", "b", ""), "f.toml", "/s")->touch, Touch::kTagged);
  EXPECT_EQ(ParseAppFile(Entry("a", "b", "touch = \"all\"\n"), "f.toml", "/s")->touch, Touch::kAll);
  EXPECT_EQ(ParseAppFile(Entry("a", "b", "touch = \"tagged\"\nplacement = \"fit\"\n"), "f.toml", "/s")->touch,
            Touch::kTagged);
  EXPECT_EQ(entry->offset_base_m, (base::Vec3{0.01, -0.02, 0.03}));
  EXPECT_EQ(entry->scale, 2);
  EXPECT_EQ(entry->up, Up::kY) << "glTF's own";
  EXPECT_EQ(ParseAppFile(Entry("a", "b", "up = \"z\"\n"), "f.toml", "/s")->up, Up::kZ);
  ExpectMentions(ErrorOf(Entry("a", "b", "up = \"x\"\n")), {"test.toml", "up", "y", "z"});
  EXPECT_EQ(entry->force_scale, 0.5);
}

TEST(ConfigApps, ReadsTagsByName) {
  const auto entry =
      ParseAppFile(Entry("a", "b",
                         "[[tag]]\nname = \"clay \\\"1\\\"\"\nstiffness = 300.5\nsoftness = {model = \"winkler\"}\n"
                         "[[tag]]\nname = \"lid\"\nrole = \"ignore\"\n"),
                   "f.toml", "/s");
  ASSERT_TRUE(entry.ok()) << entry.error();
  const auto json = nlohmann::json::parse(entry->tags, nullptr, false);
  EXPECT_EQ(
      json,
      nlohmann::json::parse(
          R"({"clay \"1\"": {"stiffness": 300.5, "softness": {"model": "winkler"}}, "lid": {"role": "ignore"}})"));
  EXPECT_EQ(ParseAppFile(Entry("a", "b"), "f.toml", "/s")->tags, "");
  ExpectMentions(ErrorOf(Entry("a", "b", "[[tag]]\nstiffness = 3\n")), {"test.toml", "tag.name", "missing"});
  ExpectMentions(ErrorOf(Entry("a", "b", "[tag]\nname = \"x\"\n")), {"test.toml", "tag", "not an array of tables"});
  ExpectMentions(ErrorOf(Entry("a", "b", "[[tag]]\nname = \"x\"\n[[tag]]\nname = \"x\"\n")), {"tag.name", "twice"});
  ExpectMentions(ErrorOf(Entry("a", "b", "[[tag]]\nname = \"x\"\nrole = \"" + std::string(5000, 'x') + "\"\n")),
                 {"tag", "the limit is 4096"});
}

TEST(ConfigApps, ReadsAndChecksLayerSettings) {
  const auto entry = ParseAppFile(
      Entry("a", "b", "profile = \"oculus/touch_controller\"\nhand = \"left\"\nrest_after_s = 2.5\n"), "f.toml", "/s");
  ASSERT_TRUE(entry.ok()) << entry.error();
  EXPECT_EQ(entry->profile, "/interaction_profiles/oculus/touch_controller");
  EXPECT_EQ(entry->hand, "left");
  EXPECT_EQ(entry->rest_after_s, 2.5);
  const auto full =
      ParseAppFile(Entry("a", "b", "profile = \"/interaction_profiles/khr/simple_controller\"\n"), "f", "/s");
  ASSERT_TRUE(full.ok()) << full.error();
  EXPECT_EQ(full->profile, "/interaction_profiles/khr/simple_controller");
  const auto none = ParseAppFile(Entry("a", "b"), "f", "/s");
  EXPECT_EQ(none->profile, "");
  EXPECT_EQ(none->hand, "auto");
  EXPECT_EQ(none->rest_after_s, 0);
  for (const char* wrong : {"Oculus Touch", "oculus", "/oculus/touch_controller", "a/b/c", "oculus/", "/", ""})
    ExpectMentions(ErrorOf(Entry("a", "b", "profile = \"" + std::string(wrong) + "\"\n")), {"test.toml", "profile"});
  ExpectMentions(ErrorOf(Entry("a", "b", "profile = \"v/" + std::string(120, 'x') + "\"\n")), {"test.toml", "profile"});
  ExpectMentions(ErrorOf(Entry("a", "b", "hand = \"both\"\n")), {"hand", "left", "right"});
  ExpectMentions(ErrorOf(Entry("a", "b", "rest_after_s = -2\n")), {"rest_after_s", "-1"});
}

TEST(ConfigApps, SuggestsTheNearestWord) {
  ExpectMentions(ErrorOf(Entry("a", "b", "profile = \"oculus/tuoch_controller\"\n")),
                 {"not a profile of the pen", "valve/index_controller", "did you mean 'oculus/touch_controller'?"});
  ExpectMentions(ErrorOf(Entry("a", "b", "hand = \"rihgt\"\n")), {"did you mean 'right'?"});
  ExpectMentions(ErrorOf(Entry("a", "b", "placment = \"fit\"\n")), {"did you mean 'placement'?"});
  ExpectMentions(ErrorOf("application = \"a\"\n[inputs]\nselect = [\"pres\"]\n"), {"did you mean 'press'?"});
}

TEST(ConfigApps, AbsoluteScenePathsAreKept) {
  const auto entry = ParseAppFile(Entry("a", "/models/../cup.glb"), "f", "/scenes");
  ASSERT_TRUE(entry.ok());
  EXPECT_EQ(entry->scene, "/cup.glb");
}

TEST(ConfigApps, UserFilesTakePrecedenceThenNameOrder) {
  const test::TempFolder user;
  const test::TempFolder shipped;
  shipped.Write("10-a.toml", Entry("game*", "shipped10.glb"));
  shipped.Write("20-c.toml", Entry("game one", "never.glb"));
  shipped.Write("05-b.toml", Entry("gamer", "shipped05.glb"));
  user.Write("90-z.toml", Entry("game one", "mine.glb"));
  const AppTable table = LoadAppTable({user.Path(), shipped.Path(), shipped.Path("no such folder")}, "/s");
  EXPECT_TRUE(table.problems.empty());
  EXPECT_EQ(FindApp(table, "game one")->scene, "/s/mine.glb");
  EXPECT_EQ(FindApp(table, "game two")->scene, "/s/shipped10.glb");
  EXPECT_EQ(FindApp(table, "gamer")->scene, "/s/shipped05.glb");
}

TEST(ConfigApps, InvalidFileIsSkippedAndReported) {
  const test::TempFolder folder;
  folder.Write("10-good.toml", Entry("good", "good.glb"));
  folder.Write("20-broken.toml", "application = \n");
  folder.Write("30-wrong.toml", Entry("wrong", "wrong.glb", "scale = -1\n"));
  folder.Write("40-also-good.toml", Entry("also", "also.glb"));
  folder.Write("50-readme.txt", "not ours");
  const AppTable table = LoadAppTable({folder.Path()}, "/s");
  EXPECT_EQ(table.entries.size(), 2u);
  EXPECT_NE(FindApp(table, "good"), nullptr);
  EXPECT_NE(FindApp(table, "also"), nullptr);
  EXPECT_EQ(FindApp(table, "wrong"), nullptr) << "no part of an invalid file is used";
  ASSERT_EQ(table.problems.size(), 2u);
  ExpectMentions(table.problems[0], {"20-broken.toml:1"});
  ExpectMentions(table.problems[1], {"30-wrong.toml:", "scale", "-1"});
}

TEST(ConfigApps, ErrorsNameFileKeyAndValue) {
  ExpectMentions(ErrorOf(""), {"test.toml", "application", "missing"});
  ExpectMentions(ErrorOf("scene = \"a.glb\"\n"), {"application", "missing"});
  ExpectMentions(ErrorOf("application = \"a\"\n"), {"scene", "missing"});
  ExpectMentions(ErrorOf("application = 7\nscene = \"a.glb\"\n"), {"test.toml:1", "application", "text"});
  ExpectMentions(ErrorOf(Entry("", "a.glb")), {"application", "1 to 127"});
  ExpectMentions(ErrorOf(Entry(std::string(128, 'a'), "a.glb")), {"application", "128"});
  ExpectMentions(ErrorOf(Entry("a", "b", "placement = \"fitted\"\n")), {"placement", "fitted", "as_authored"});
  ExpectMentions(ErrorOf(Entry("a", "b", "force_scale = 1.5\n")), {"force_scale", "1.5", "[0, 1]"});
  ExpectMentions(ErrorOf(Entry("a", "b", "force_scale = nan\n")), {"force_scale", "nan"});
  ExpectMentions(ErrorOf(Entry("a", "b", "offset_base_m = [0, 0]\n")), {"offset_base_m", "3 numbers"});
  ExpectMentions(ErrorOf(Entry("a", "b", "offset_base_m = [0, 0, 1]\n")), {"offset_base_m[2]", "[-0.2, 0.2]"});
  ExpectMentions(ErrorOf(Entry("a", "b", "scael = 2\n")), {"test.toml:3", "scael", "unknown", "scale"});
  ExpectMentions(ErrorOf(Entry("a\\u0007", "b")), {"control characters"});
}

TEST(ConfigApps, ReportsFilesBeyondTheLimit) {
  const test::TempFolder folder;
  for (std::size_t i = 0; i <= kMaxAppFiles; ++i) {
    folder.Write(std::to_string(1000 + i) + ".toml", Entry("a" + std::to_string(i), "b"));
  }
  const AppTable table = LoadAppTable({folder.Path()}, "/s");
  EXPECT_EQ(table.entries.size(), kMaxAppFiles);
  ASSERT_EQ(table.problems.size(), 1u);
  ExpectMentions(table.problems[0], {"257", "256", "1256.toml"});
}

TEST(ConfigPaths, DataFolderIsFromEnvironmentOrBesideTheProgram) {
  {
    const test::ScopedVariable chosen("OMNI_DATA_DIR", "/some/where");
    EXPECT_EQ(DataFolder(), "/some/where");
    EXPECT_EQ(ScenesFolder(), "/some/where/scenes");
  }
  const test::ScopedVariable none("OMNI_DATA_DIR", std::nullopt);
  EXPECT_EQ(DataFolder(), OMNI_BINARY_DIR "/share/omni");
  EXPECT_TRUE(std::filesystem::exists(DataFolder() + "/apps.d/20-dragon.toml"));
}

TEST(ConfigPaths, UserFolderComesFirst) {
  const test::ScopedVariable data("OMNI_DATA_DIR", "/data");
  const test::ScopedVariable home("HOME", "/home/me");
  {
    const test::ScopedVariable config("XDG_CONFIG_HOME", "/cfg");
    EXPECT_EQ(AppFolders(), (std::vector<std::string>{"/cfg/omni/apps.d", "/data/apps.d"}));
  }
  {
    const test::ScopedVariable relative("XDG_CONFIG_HOME", "cfg");  // the XDG rules ignore it
    EXPECT_EQ(UserAppFolder(), "/home/me/.config/omni/apps.d");
  }
  const test::ScopedVariable config("XDG_CONFIG_HOME", std::nullopt);
  const test::ScopedVariable nobody("HOME", std::nullopt);
  EXPECT_EQ(AppFolders(), (std::vector<std::string>{"/data/apps.d"}));
}

}  // namespace test_config_apps
}  // namespace omni::config
