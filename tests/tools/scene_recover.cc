// omni scene recover: lists, writes and discards journals, without omnid.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include <nlohmann/json.hpp>

#include "service/haptics/live/make_live.h"
#include "service/scene/journal/journal_folder.h"
#include "service/scene/journal/sculpt_journal.h"
#include "service/scene/scene_file.h"
#include "service/tools/common/command_line.h"
#include "tests/haptics/scenario.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/scoped_variable.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_scene_recover {

using nlohmann::json;
using test::Outcome;
using test::RunOmni;

class SceneRecover : public testing::Test {
 protected:
  // The journal of a lump with three strokes, as a session left it.
  std::string Sculpt(std::shared_ptr<scene::SculptJournal>* open = nullptr) {
    haptics::Material clay;
    clay.sculpt.enabled = true;
    haptics::SceneInput input = haptics::SceneOf(haptics::Sphere(4, 0.02), clay);
    input.objects[0].name = "lump";
    haptics::Scene scene = haptics::Built(input);
    haptics::MakeLive(scene);
    std::vector<scene::JournalNote> notes;
    const std::string folder = folder_.Path("omni/sculpt");
    const auto journals = scene::RestoreJournals(
        scene, {.folder = folder, .application = "app", .file = "lump.glb", .patience = {}, .limits = {}}, notes);
    haptics::sculpt::SculptEditor& editor = scene.live()->sculpt_session_at(0).editor();
    editor.SetLog([&](haptics::sculpt::EditKind, const haptics::sculpt::UndoStep& step) {
      journals[0]->Append(scene::RecordKind::kStroke, step);
    });
    for (int k = 0; k < 3; ++k) {
      EXPECT_TRUE(editor.Stroke(editor.Locate({0, 0, 0.02}, 1), {}, 0.001).ok());
      editor.Publish();
    }
    EXPECT_TRUE(journals[0]->Flush());
    if (open != nullptr) *open = journals[0];
    return std::filesystem::path(scene::JournalsIn(folder)[0]).stem().string();
  }
  const test::TempFolder folder_;
  const test::ScopedVariable state_{"XDG_STATE_HOME", folder_.Path()};
};

TEST_F(SceneRecover, ListsWhatIsKept) {
  Outcome said = RunOmni({"scene", "recover"});
  EXPECT_EQ(said.status, 0);
  EXPECT_NE(said.out.find("no strokes are kept"), std::string::npos) << said.out;
  std::shared_ptr<scene::SculptJournal> open;
  const std::string name = Sculpt(&open);
  said = RunOmni({"scene", "recover"});
  EXPECT_NE(said.out.find(name), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("lump of lump.glb, app: 3 strokes"), std::string::npos) << said.out;
  said = RunOmni({"scene", "recover", "--json"});
  const json list = json::parse(said.out);
  ASSERT_EQ(list["journals"].size(), 1U);
  EXPECT_EQ(list["journals"][0]["name"], name);
  EXPECT_EQ(list["journals"][0]["strokes"], 3);
  EXPECT_EQ(list["journals"][0]["saved"], false);
  EXPECT_EQ(list["journals"][0]["in_use"], true);
}

TEST_F(SceneRecover, WritesAWholeFileAndReplacesOnlyWithForce) {
  const std::string name = Sculpt(), out = folder_.Path("out.glb");
  Outcome said = RunOmni({"scene", "recover", name, "-o", out});
  EXPECT_EQ(said.status, 0) << said.err;
  EXPECT_NE(said.out.find("lump with 3 strokes"), std::string::npos) << said.out;
  scene::LoadReport report;
  const auto loaded = scene::LoadSceneFile(out, {}, report);
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  double top_m = 0;
  for (const base::Vec3& v : loaded->objects.at(0).vertices_base_m) top_m = std::max(top_m, v.z);
  EXPECT_GT(top_m, 0.0225) << "three strokes of a millimetre";
  EXPECT_TRUE(loaded->materials.at(0).sculpt.enabled);
  said = RunOmni({"scene", "recover", name + ".journal", "-o", out});
  EXPECT_EQ(said.status, kExitFailed);
  EXPECT_NE(said.err.find("already exists"), std::string::npos) << said.err;
  EXPECT_EQ(
      RunOmni({"scene", "recover", folder_.Path("omni/sculpt/" + name + ".journal"), "-o", out, "--force"}).status, 0);
}

TEST_F(SceneRecover, DiscardsOnlyWhatIsNotInUse) {
  std::shared_ptr<scene::SculptJournal> open;
  const std::string name = Sculpt(&open);
  Outcome said = RunOmni({"scene", "recover", name, "--discard"});
  EXPECT_EQ(said.status, kExitFailed);
  EXPECT_NE(said.err.find("is in use; end the application's session first"), std::string::npos) << said.err;
  open->Close();
  EXPECT_EQ(RunOmni({"scene", "recover", name, "--discard"}).status, 0);
  EXPECT_TRUE(scene::JournalsIn(folder_.Path("omni/sculpt")).empty());
}

TEST_F(SceneRecover, RefusesWhatItCannotDo) {
  const std::string name = Sculpt();
  const std::string other = folder_.Write("other.txt", "no journal");
  EXPECT_EQ(RunOmni({"scene", "recover", other, "--discard"}).status, kExitFailed);
  EXPECT_TRUE(std::filesystem::exists(other));
  EXPECT_EQ(RunOmni({"scene", "recover", "--discard"}).status, kExitUsage);
  EXPECT_EQ(RunOmni({"scene", "recover", name}).status, kExitUsage) << "neither -o nor --discard";
  const Outcome said = RunOmni({"scene", "recover", "vase", "-o", folder_.Path("a.glb"), "--json"});
  EXPECT_EQ(said.status, kExitFailed);
  EXPECT_NE(json::parse(said.out)["error"].get<std::string>().find("no journal 'vase'"), std::string::npos) << said.out;
  std::ofstream(folder_.Path("omni/sculpt/" + name + ".journal")) << "something else";
  EXPECT_EQ(RunOmni({"scene", "recover", name, "-o", folder_.Path("a.glb")}).status, kExitFailed);
  EXPECT_FALSE(std::filesystem::exists(folder_.Path("a.glb")));
  EXPECT_NE(RunOmni({"scene", "recover"}).out.find("no sculpt journal can be read from it"), std::string::npos);
}

}  // namespace test_tools_scene_recover
}  // namespace omni::tools
