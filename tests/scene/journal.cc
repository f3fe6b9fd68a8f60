// Sculpt journals: strokes come back, to the bit, whatever has happened to the disk, the file or the scene; and nothing
// that was not saved is ever removed or overwritten.
#include "service/scene/journal/journal_folder.h"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <random>

#include "service/haptics/live/make_live.h"
#include "service/scene/glb_save.h"
#include "service/scene/journal/sculpt_journal.h"
#include "tests/haptics/scenario.h"
#include "tests/support/process/temp_folder.h"

namespace omni::scene {
namespace test_scene_journal {

namespace fs = std::filesystem;
using haptics::sculpt::EditKind;
using haptics::sculpt::SculptEditor;
using haptics::sculpt::UndoStep;

std::string BytesOf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

// An application's session with a lump of clay, as omnid holds it.
class Lump {
 public:
  explicit Lump(const std::string& folder, int n = 4, const std::string& application = "app", JournalLimits limits = {})
      : random_(7) {
    haptics::Material clay;
    clay.sculpt.enabled = true;
    clay.stiffness_N_m = 321;
    haptics::SceneInput input = haptics::SceneOf(haptics::Sphere(n, 0.02), clay);
    input.objects[0].name = "lump";
    scene_ = haptics::Built(input);
    haptics::MakeLive(scene_);
    auto journals =
        RestoreJournals(scene_, {folder, application, "lump.glb", std::chrono::milliseconds(0), limits}, notes);
    if (!journals.empty()) journal = journals[0];
    if (journal == nullptr) return;
    editor().SetLog([this](EditKind kind, const UndoStep& step) {
      constexpr RecordKind kKinds[] = {RecordKind::kStroke, RecordKind::kUndo, RecordKind::kRedo};
      journal->Append(kKinds[static_cast<std::size_t>(kind)], step);
    });
  }
  SculptEditor& editor() { return scene_.live()->sculpt_session_at(0).editor(); }
  std::uint64_t hash() { return editor().mesh().Hash(); }
  void Stroke() {
    haptics::sculpt::Brush brush;
    brush.radius_m = 0.008;
    const auto at = editor().Locate(random_.InBox(0.02), 1);
    ASSERT_TRUE(editor().Stroke(at, brush, random_.Uniform(-0.002, 0.003)).ok());
    editor().Publish();
  }
  void Strokes(int count) {
    for (int k = 0; k < count; ++k) Stroke();
  }
  std::string said() const {
    std::string text;
    for (const JournalNote& note : notes) text += note.text + "\n";
    return text;
  }

  std::vector<JournalNote> notes;
  std::shared_ptr<SculptJournal> journal;

 private:
  haptics::Scene scene_;
  haptics::Random random_;
};

class SculptJournals : public testing::Test {
 protected:
  std::string folder() const { return folder_.Path("state/omni/sculpt"); }
  std::string only() const {
    const std::vector<std::string> paths = JournalsIn(folder());
    EXPECT_EQ(paths.size(), 1U);
    return paths.empty() ? "" : paths[0];
  }
  const test::TempFolder folder_;
};

TEST_F(SculptJournals, StrokesUndoAndRedoComeBack) {
  std::uint64_t hash = 0, undone = 0;
  {
    Lump lump(folder());
    EXPECT_TRUE(lump.journal->Flush());
    EXPECT_TRUE(JournalsIn(folder()).empty()) << "no stroke, no file";
    lump.Strokes(5);
    lump.editor().Undo();
    undone = lump.hash();
    lump.editor().Undo();
    hash = lump.hash();
    EXPECT_TRUE(lump.journal->Flush());
    EXPECT_EQ(lump.journal->state().strokes, 3U);
    struct stat info {};
    ASSERT_EQ(::stat(folder().c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777U, 0700U);
    ASSERT_EQ(::stat(only().c_str(), &info), 0);
    EXPECT_EQ(info.st_mode & 0777U, 0600U);
  }
  for (int round = 0; round < 3; ++round) {
    Lump lump(folder());
    EXPECT_EQ(lump.hash(), hash);
    EXPECT_NE(lump.said().find("lump.glb: lump: restored 3 strokes from 20"), std::string::npos) << lump.said();
    EXPECT_EQ(lump.editor().redo_steps(), 2U);
    ASSERT_TRUE(lump.editor().Redo());
    EXPECT_EQ(lump.hash(), undone);
    ASSERT_TRUE(lump.editor().Undo());
    ASSERT_TRUE(lump.journal->Flush());
  }
  {
    Lump lump(folder());
    lump.Strokes(2);  // nothing to redo any more
    hash = lump.hash();
    ASSERT_TRUE(lump.journal->Flush());
  }
  Lump lump(folder());
  EXPECT_EQ(lump.hash(), hash);
  EXPECT_EQ(lump.editor().undo_steps(), 5U);
  EXPECT_EQ(lump.editor().redo_steps(), 0U);
  while (lump.editor().Undo()) {
  }
  EXPECT_EQ(lump.hash(), Lump("").hash()) << "as the file has it";
}

TEST_F(SculptJournals, OpenStrokeComesBackAsAWholeOne) {
  std::uint64_t hash = 0;
  {
    Lump lump(folder());
    lump.Strokes(2);
    haptics::sculpt::Brush brush;
    ASSERT_TRUE(lump.editor().Begin(lump.editor().Locate({0, 0, 0.02}, 1), brush).ok());
    for (int k = 1; k <= 3; ++k) {
      lump.editor().MoveTo(1e-3 * k);
      lump.journal->Append(RecordKind::kOpen, lump.editor().OpenStep());
      ASSERT_TRUE(lump.journal->Flush());
    }
    hash = lump.hash();
  }
  for (int round = 0; round < 2; ++round) {
    Lump lump(folder());
    EXPECT_EQ(lump.hash(), hash);
    EXPECT_EQ(lump.editor().undo_steps(), 3U);
    ASSERT_TRUE(lump.journal->Flush());  // the second time it is closed in the file
  }
}

// Every byte of a journal changed, and every length: what is before the damage is used, exactly.
TEST_F(SculptJournals, DamageAnywhereLosesNothingBeforeIt) {
  std::vector<std::uint64_t> ends;  // of whole records
  {
    Lump lump(folder(), 2);
    for (int k = 0; k < 3; ++k) {
      lump.Stroke();
      ASSERT_TRUE(lump.journal->Flush());
      ends.push_back(fs::file_size(only()));
    }
  }
  const std::string whole = BytesOf(only());
  const JournalContent good = *ParseJournal(whole);
  ASSERT_EQ(good.edits.steps.size(), 3U);
  const auto check = [&](const std::string& bytes, std::size_t at) {
    const std::size_t strokes =
        static_cast<std::size_t>(std::count_if(ends.begin(), ends.end(), [&](std::uint64_t end) { return end <= at; }));
    const auto content = ParseJournal(bytes);
    if (!content.ok()) return strokes == 0 && !content.error().empty();
    return content->edits.steps.size() == strokes && content->edits.done == strokes &&
           std::equal(content->edits.steps.begin(), content->edits.steps.end(), good.edits.steps.begin()) &&
           content->head.identity == good.head.identity && content->good_bytes <= at;
  };
  for (std::size_t length = 0; length < whole.size(); ++length) ASSERT_TRUE(check(whole.substr(0, length), length));
  for (std::size_t at = 0; at < whole.size(); ++at) {
    std::string bytes = whole;
    bytes[at] = static_cast<char>(bytes[at] ^ (1 << (at % 8)));
    ASSERT_TRUE(check(bytes, at)) << "byte " << at;
  }
  // And one of them through the whole way.
  const std::string path = only();
  std::string torn = whole.substr(0, ends[1] + 100);
  std::ofstream(path, std::ios::binary) << torn;
  Lump lump(folder(), 2);
  EXPECT_EQ(lump.editor().undo_steps(), 2U);
  EXPECT_NE(lump.said().find("torn or damaged after " + std::to_string(ends[1]) + " bytes"), std::string::npos)
      << lump.said();
  lump.Stroke();
  ASSERT_TRUE(lump.journal->Flush());
  const std::uint64_t hash = lump.hash();
  lump.journal->Close();
  Lump again(folder(), 2);
  EXPECT_EQ(again.hash(), hash);
  EXPECT_EQ(again.notes.size(), 1U) << again.said();
}

// What a person or another program has written there with right checksums.
TEST_F(SculptJournals, UnusableJournalIsPutAsideAndKept) {
  JournalHead head;
  {
    Lump lump(folder());
    lump.Stroke();
    ASSERT_TRUE(lump.journal->Flush());
  }
  const std::string path = only();
  JournalContent content = *ReadJournal(path);
  std::string bytes = RecordBytes(RecordKind::kHead, 0, 0, HeadPayload(content.head)) +
                      RecordBytes(RecordKind::kRest, 1, 0, StepPayload(content.rest));
  content.edits.steps[0].words[8] ^= 0xFFFF;  // a neighbour of a triangle that is used
  std::ofstream(path, std::ios::binary) << bytes + RecordBytes(RecordKind::kStroke, 2, 0,
                                                               StepPayload(content.edits.steps[0]));
  {
    Lump lump(folder());
    EXPECT_EQ(lump.hash(), Lump("").hash());
    EXPECT_NE(lump.said().find("do not lead to a surface"), std::string::npos) << lump.said();
    lump.Stroke();
    ASSERT_TRUE(lump.journal->Flush());
  }
  ASSERT_EQ(JournalsIn(folder()).size(), 2U);
  EXPECT_FALSE(SculptedByJournal(*ReadJournal(JournalsIn(folder())[0])).ok());
  std::ofstream(path, std::ios::binary) << "something else";
  Lump lump(folder());
  EXPECT_EQ(JournalsIn(folder()).size(), 2U);
  EXPECT_TRUE(fs::exists(path.substr(0, path.size() - 8) + ".damaged-2.journal")) << lump.said();
}

TEST_F(SculptJournals, ChangedSceneIsNotTouchedAndItsStrokesAreKept) {
  {
    Lump lump(folder(), 4);
    lump.Strokes(3);
    ASSERT_TRUE(lump.journal->Flush());
  }
  const std::string before = BytesOf(only());
  {
    Lump lump(folder(), 5);
    EXPECT_EQ(lump.editor().undo_steps(), 0U);
    EXPECT_NE(lump.said().find("the scene's file has changed since"), std::string::npos) << lump.said();
    lump.Stroke();
    ASSERT_TRUE(lump.journal->Flush());
  }
  const std::vector<std::string> paths = JournalsIn(folder());
  ASSERT_EQ(paths.size(), 2U);
  EXPECT_NE(paths[0].find(".changed.journal"), std::string::npos);
  EXPECT_EQ(BytesOf(paths[0]), before);
  EXPECT_EQ(Lump(folder(), 5).editor().undo_steps(), 1U);
}

TEST_F(SculptJournals, SecondSessionGetsItsOwnJournal) {
  Lump first(folder());
  first.Strokes(2);
  ASSERT_TRUE(first.journal->Flush());
  Lump second(folder());
  EXPECT_EQ(second.editor().undo_steps(), 0U);
  EXPECT_NE(second.said().find("another session sculpts it too"), std::string::npos) << second.said();
  second.Stroke();
  ASSERT_TRUE(second.journal->Flush());
  first.Stroke();
  ASSERT_TRUE(first.journal->Flush());
  EXPECT_EQ(JournalsIn(folder()).size(), 2U);
  EXPECT_TRUE(IsJournalInUse(JournalsIn(folder())[0]));
  EXPECT_FALSE(DiscardJournal(JournalsIn(folder())[0]).ok());
  const std::uint64_t hash_first = first.hash(), hash_second = second.hash();
  first.journal->Close();
  second.journal->Close();
  Lump other(folder(), 4, "another application");
  EXPECT_EQ(other.editor().undo_steps(), 0U) << "each application has its own";
  Lump third(folder()), fourth(folder());
  EXPECT_EQ(third.hash(), hash_first);
  EXPECT_EQ(fourth.hash(), hash_second);
}

TEST_F(SculptJournals, FullDiskIsSaidOnceAndNothingIsLostWhenItWorksAgain) {
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
  std::uint64_t hash = 0;
  for (const bool at_once : {true, false}) {
    Lump lump(folder());
    if (!at_once) {
      lump.Strokes(2);
      ASSERT_TRUE(lump.journal->Flush());
    }
    const rlimit full{at_once ? 1000 : fs::file_size(only()) + 1000, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &full), 0);
    for (int k = 0; k < 4; ++k) {
      lump.Stroke();
      EXPECT_FALSE(lump.journal->Flush());
    }
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &before), 0);
    auto note = lump.journal->PopNote();
    ASSERT_TRUE(note);
    EXPECT_NE(note->text.find("exceeds the maximum file size"), std::string::npos) << note->text;
    EXPECT_EQ(lump.journal->state().problem, note->text);
    EXPECT_FALSE(lump.journal->PopNote()) << "once";
    if (!at_once) {
      EXPECT_TRUE(ReadJournal(only())->damage.empty());
    }
    lump.editor().Undo();
    EXPECT_TRUE(lump.journal->Flush());
    note = lump.journal->PopNote();
    ASSERT_TRUE(note);
    EXPECT_NE(note->text.find("strokes are kept again"), std::string::npos) << note->text;
    EXPECT_EQ(lump.journal->state().problem, "");
    hash = lump.hash();
    lump.journal->Close();
    EXPECT_EQ(Lump(folder()).hash(), hash);
  }
}

TEST_F(SculptJournals, UnwritableFolderIsSaidAndTriedAgain) {
  folder_.Write("state/omni", "a file in its place");
  Lump lump(folder());
  lump.Strokes(2);
  EXPECT_FALSE(lump.journal->Flush());
  EXPECT_NE(lump.journal->state().problem.find("cannot be created"), std::string::npos)
      << lump.journal->state().problem;
  fs::remove(folder_.Path("state/omni"));
  EXPECT_TRUE(lump.journal->Flush());
  EXPECT_EQ(ReadJournal(only())->strokes(), 2U);
  fs::remove(only());  // by a person, while it is in use
  lump.Stroke();
  EXPECT_TRUE(lump.journal->Flush());
  lump.journal->Close();
  EXPECT_EQ(Lump(folder()).hash(), lump.hash());
}

TEST_F(SculptJournals, GrowingJournalIsShortenedAndUndoGoesOn) {
  const JournalLimits small{.growth_bytes = 60'000, .undo_bytes = 20'000};
  std::uint64_t hash = 0;
  std::uintmax_t longest = 0;
  {
    Lump lump(folder(), 4, "app", small);
    for (int k = 0; k < 60; ++k) {
      lump.Stroke();
      ASSERT_TRUE(lump.journal->Flush());
      longest = std::max(longest, fs::file_size(only()));
    }
    ASSERT_EQ(lump.journal->state().problem, "");
    for (int k = 0; k < 55; ++k) ASSERT_TRUE(lump.editor().Undo());  // further than the journal's own strokes
    for (int k = 0; k < 25; ++k) ASSERT_TRUE(lump.editor().Redo());
    ASSERT_TRUE(lump.journal->Flush());
    hash = lump.hash();
    EXPECT_TRUE(IsJournalInUse(only()));
    EXPECT_GT(ReadJournal(only())->merged, 0);
    // The object before and after, what is not merged yet, and some kilobytes of the head and the newest stroke.
    const std::uint64_t surface = lump.editor().mesh().page_count() * sizeof(haptics::sculpt::PageContent);
    EXPECT_LT(longest, 2 * surface + small.growth_bytes + small.undo_bytes + 100'000);
  }
  {
    Lump lump(folder(), 4, "app", small);
    EXPECT_EQ(lump.hash(), hash);
    EXPECT_NE(lump.said().find("restored 30 strokes"), std::string::npos) << lump.said();
    lump.Strokes(3);
    hash = lump.hash();
    ASSERT_TRUE(lump.journal->Flush());
  }
  EXPECT_EQ(Lump(folder(), 4, "app", small).hash(), hash);
}

TEST_F(SculptJournals, OnlySavedJournalsMakeRoom) {
  const auto sculpt = [&](const std::string& application, JournalLimits limits, bool save) {
    Lump lump(folder(), 4, application, limits);
    lump.Stroke();
    if (save) lump.journal->MarkSaved(lump.journal->edits());
    const bool kept = lump.journal->Flush();
    EXPECT_EQ(lump.journal->state().saved, save);
    return kept ? std::string() : lump.journal->state().problem;
  };
  EXPECT_EQ(sculpt("saved", {}, true), "");
  EXPECT_TRUE(ReadJournal(only())->saved);
  const std::uintmax_t one = fs::file_size(only());
  EXPECT_EQ(sculpt("not saved", {}, false), "");
  const JournalLimits two{.folder_bytes = 2 * one + one / 2};
  EXPECT_EQ(sculpt("third", two, false), "") << "the saved one goes";
  EXPECT_EQ(JournalsIn(folder()).size(), 2U);
  const std::string problem = sculpt("fourth", two, false);
  EXPECT_NE(problem.find("of strokes that were not saved, the limit is"), std::string::npos) << problem;
  EXPECT_EQ(JournalsIn(folder()).size(), 2U);
  ASSERT_TRUE(DiscardJournal(JournalsIn(folder())[0]).ok());
  EXPECT_EQ(sculpt("fourth", two, false), "");
}

TEST_F(SculptJournals, SavedEndsWithTheNextStroke) {
  Lump lump(folder());
  lump.Stroke();
  const std::uint64_t then = lump.journal->edits();
  lump.Stroke();
  lump.journal->MarkSaved(then);
  EXPECT_FALSE(lump.journal->state().saved) << "the stroke after it is not in the file";
  lump.journal->MarkSaved(lump.journal->edits());
  ASSERT_TRUE(lump.journal->Flush());
  EXPECT_TRUE(ReadJournal(only())->saved);
  lump.editor().Undo();
  ASSERT_TRUE(lump.journal->Flush());
  EXPECT_FALSE(ReadJournal(only())->saved);
}

TEST_F(SculptJournals, RecoveredSceneIsThatOfTheEditor) {
  Lump lump(folder());
  lump.Strokes(6);
  ASSERT_TRUE(lump.journal->Flush());
  const auto scene = SculptedByJournal(*ReadJournal(only()));
  ASSERT_TRUE(scene.ok()) << scene.error();
  const haptics::Mesh mesh = lump.editor().Snapshot();
  ASSERT_EQ(scene->objects.size(), 1U);
  EXPECT_EQ(scene->objects[0].name, "lump");
  EXPECT_EQ(scene->objects[0].triangles, mesh.triangles);
  ASSERT_EQ(scene->objects[0].vertices_base_m.size(), mesh.vertices.size());
  for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
    EXPECT_EQ(Norm(scene->objects[0].vertices_base_m[v] - mesh.vertices[v]), 0);
  }
  ASSERT_EQ(scene->materials.size(), 1U);
  EXPECT_EQ(scene->materials[0].stiffness_N_m, 321);
  EXPECT_TRUE(scene->materials[0].sculpt.enabled);
  EXPECT_TRUE(GlbBytes(*scene).ok());
}

// Damaged journals with right checksums, as only an enemy writes them: refused, or a sound surface. Sanitizers
// watch; scripts/fuzz runs more, by OMNI_FUZZ.
TEST(SculptJournalFuzz, DamagedJournalsAreRefusedOrLeadToASoundSurface) {
  const char* asked = std::getenv("OMNI_FUZZ");
  const long count = asked != nullptr ? std::atol(asked) : 400;
  const test::TempFolder folder;
  {
    Lump lump(folder.Path("sculpt"), 2);
    lump.Strokes(3);
    lump.editor().Undo();
    ASSERT_TRUE(lump.journal->Flush());
  }
  const JournalContent good = *ReadJournal(JournalsIn(folder.Path("sculpt"))[0]);
  std::mt19937 random(3);
  const auto below = [&](std::size_t n) { return std::uniform_int_distribution<std::size_t>(0, n - 1)(random); };
  long refused = 0, sound = 0;
  for (long round = 0; round < count; ++round) {
    std::vector<std::pair<RecordKind, std::string>> records = {
        {RecordKind::kHead, HeadPayload(good.head)}, {RecordKind::kRest, std::string(StepPayload(good.rest))}};
    for (const UndoStep& step : good.edits.steps) records.emplace_back(RecordKind::kStroke, StepPayload(step));
    records.emplace_back(RecordKind::kUndo, "");
    for (std::size_t k = 0; k <= below(3); ++k) {
      auto& [kind, payload] = records[below(records.size())];
      const std::size_t what = below(8);
      if (what == 0) {
        kind = static_cast<RecordKind>(1 + below(10));
      } else if (what == 1) {
        payload.resize(8 * below(payload.size() / 8 + 4));
      } else if (!payload.empty()) {
        payload[below(payload.size())] ^= static_cast<char>(1 << below(8));
      }
    }
    std::string bytes;
    std::uint32_t number = 0;
    for (const auto& [kind, payload] : records) bytes += RecordBytes(kind, number++, 0, payload);
    const auto content = ParseJournal(bytes);
    const auto scene = content.ok() ? SculptedByJournal(*content) : base::Result<haptics::SceneInput>(base::Error{});
    if (!scene.ok()) {
      ++refused;
      continue;
    }
    ++sound;
    EXPECT_TRUE(GlbBytes(*scene).ok());
    Lump lump("", 2);
    if (content->head.identity == lump.hash() && lump.editor().Restore(content->Closed()).ok()) lump.Stroke();
  }
  RecordProperty("journals", std::to_string(count));
  RecordProperty("refused", std::to_string(refused));
  EXPECT_GT(refused, count / 4);
  EXPECT_GT(sound, 0);
}

}  // namespace test_scene_journal
}  // namespace omni::scene
