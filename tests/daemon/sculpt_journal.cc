// Journals behind the sculpt thread: every stroke is on the disk soon after it ended, a long one while it goes on, and
// the file is free for the next session once the scene is gone.
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "service/daemon/scenes/sculpt_thread.h"
#include "service/haptics/live/make_live.h"
#include "service/scene/journal/journal_folder.h"
#include "service/scene/journal/sculpt_journal.h"
#include "tests/haptics/scenario.h"
#include "tests/support/in_time.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {
namespace test_daemon_sculpt_journal {

using haptics::sculpt::StrokeKind;
using haptics::sculpt::StrokeMessage;
using test::InTime;

constexpr double kRadius_m = 0.02;

class SculptThreadJournal : public testing::Test {
 protected:
  // A session of the application; what an earlier one did is restored.
  std::shared_ptr<const haptics::Scene> Enter() {
    haptics::Material clay;
    clay.sculpt.enabled = true;
    haptics::SceneInput input = haptics::SceneOf(haptics::Sphere(16, kRadius_m), clay);
    input.objects[0].name = "lump";
    haptics::Scene scene = haptics::Built(input);
    haptics::MakeLive(scene);
    std::vector<scene::JournalNote> notes;
    const auto journals =
        scene::RestoreJournals(scene, {.folder = journals_, .application = "app", .file = "lump.glb"}, notes);
    const auto shared = std::make_shared<const haptics::Scene>(std::move(scene));
    thread_.Add(1, "lump.glb", shared, journals);
    thread_.EnterScene(*shared);
    return shared;
  }
  void Leave(const haptics::Scene& scene) {
    thread_.LeaveScene(scene);
    thread_.Remove(scene);
  }
  void Send(const haptics::Scene& scene, StrokeKind kind, double offset_m = 0) {
    haptics::sculpt::SculptSession& session = scene.live()->sculpt_session_at(0);
    StrokeMessage message;
    message.kind = kind;
    message.stroke = kind == StrokeKind::kBegin ? ++stroke_ : stroke_;
    message.point_base_m = {0, 0, kRadius_m};
    message.brush = session.brush();
    message.offset_m = offset_m;
    ASSERT_TRUE(InTime([&] { return session.ring().TryPush(message); }));
  }
  void Stroke(const haptics::Scene& scene, double offset_m) {
    Send(scene, StrokeKind::kBegin);
    Send(scene, StrokeKind::kMove, offset_m);
    Send(scene, StrokeKind::kEnd);
  }
  // In the file, as a crash would leave it; 0: there is none.
  std::uint64_t Kept() const {
    const std::vector<std::string> paths = scene::JournalsIn(journals_);
    const auto content = paths.empty() ? base::Error{} : scene::ReadJournal(paths[0]);
    return content.ok() ? content->strokes() : 0;
  }
  SculptAnswer Request(SculptAction action) {
    thread_.Request({.asker = 9, .action = action}, 0);
    std::optional<SculptAnswer> answer;
    EXPECT_TRUE(InTime([&] { return (answer = thread_.PopAnswer()).has_value(); }));
    return answer ? std::move(*answer) : SculptAnswer();
  }

  const test::TempFolder folder_;
  const std::string journals_ = folder_.Path("sculpt");
  SculptThread thread_;
  std::uint32_t stroke_ = 0;
};

TEST_F(SculptThreadJournal, StrokesAreKeptAndComeBackInTheNextSession) {
  for (std::uint64_t session = 1; session <= 3; ++session) {
    const auto scene = Enter();
    EXPECT_EQ(scene->live()->sculpt_session_at(0).editor().undo_steps(), session - 1);
    Stroke(*scene, 0.001);
    EXPECT_TRUE(InTime([&] { return Kept() == session; }));
    Leave(*scene);  // and at once again: its file is free in time
  }
}

TEST_F(SculptThreadJournal, LongStrokeIsKeptWhileItGoesOn) {
  const auto scene = Enter();
  Send(*scene, StrokeKind::kBegin);
  for (int k = 1; Kept() == 0; ++k) {
    ASSERT_LT(k, 3000) << "it lasts three seconds";
    Send(*scene, StrokeKind::kMove, 1e-6 * k);
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(scene->live()->sculpt_session_at(0).editor().undo_steps(), 0U) << "it is still open";
  Leave(*scene);
  EXPECT_TRUE(InTime([&] { return !scene::IsJournalInUse(scene::JournalsIn(journals_)[0]); }));
  EXPECT_EQ(Kept(), 1U);
}

TEST_F(SculptThreadJournal, UndoIsKeptAndSavingIsMarked) {
  const auto scene = Enter();
  Stroke(*scene, 0.001);
  Stroke(*scene, 0.002);
  ASSERT_TRUE(InTime([&] { return Kept() == 2; }));
  ASSERT_TRUE(Request(SculptAction::kUndo).ok);
  ASSERT_TRUE(InTime([&] { return Kept() == 1; }));
  const auto saved = [&] { return scene::ReadJournal(scene::JournalsIn(journals_)[0])->saved; };
  const SculptAnswer answer = Request(SculptAction::kSave);
  ASSERT_TRUE(answer.ok);
  EXPECT_FALSE(saved()) << "the client has not got it yet";
  thread_.ConfirmSaved(answer);
  EXPECT_TRUE(InTime(saved));
}

TEST_F(SculptThreadJournal, DiskThatTakesNothingIsReportedAndTriedAgain) {
  folder_.Write("sculpt", "a file in its place");
  const auto scene = Enter();
  Stroke(*scene, 0.001);
  std::optional<SculptProblem> note;
  ASSERT_TRUE(InTime([&] { return (note = thread_.PopJournalNote()).has_value(); }));
  EXPECT_EQ(note->level, 1);
  EXPECT_NE(note->text.find("strokes are not kept"), std::string::npos) << note->text;
  std::filesystem::remove(journals_);
  ASSERT_TRUE(InTime([&] { return (note = thread_.PopJournalNote()).has_value(); }));
  EXPECT_EQ(note->level, 0);
  EXPECT_EQ(Kept(), 1U);
}

TEST_F(SculptThreadJournal, EndOfASessionKeepsTheOpenStroke) {
  const auto scene = Enter();
  Stroke(*scene, 0.001);
  Send(*scene, StrokeKind::kBegin);
  Send(*scene, StrokeKind::kMove, 0.001);
  Leave(*scene);
  EXPECT_TRUE(InTime([&] { return Kept() == 2; }));
}

}  // namespace test_daemon_sculpt_journal
}  // namespace omni::daemon
