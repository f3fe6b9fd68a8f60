// The sculpt thread: runs only while it is needed, applies strokes, executes requests, and never frees pages that a
// tick reads.
#include <gtest/gtest.h>
#include <sys/mman.h>

#include <atomic>

#include <nlohmann/json.hpp>

#include "service/daemon/scenes/sculpt_thread.h"
#include "service/haptics/live/make_live.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/sculpt/sculpt_query.h"
#include "service/scene/scene_file.h"
#include "tests/haptics/scenario.h"
#include "tests/support/in_time.h"
#include "tests/support/process/temp_folder.h"

namespace omni::daemon {
namespace test_daemon_sculpt {

using haptics::sculpt::StrokeKind;
using haptics::sculpt::StrokeMessage;
using test::InTime;

constexpr double kRadius_m = 0.02;

std::shared_ptr<const haptics::Scene> Lumps(int count) {
  haptics::Material clay;
  clay.sculpt.enabled = true;
  haptics::SceneInput input = haptics::SceneOf(haptics::Sphere(16, kRadius_m), clay);
  input.objects[0].name = "lump 0";
  for (int k = 1; k < count; ++k) {
    input.objects.push_back(haptics::Sphere(16, kRadius_m));
    input.objects.back().name = "lump " + std::to_string(k);
    for (base::Vec3& v : input.objects.back().vertices_base_m) v.x += 0.05 * k;
  }
  haptics::Scene scene = haptics::Built(input);
  haptics::MakeLive(scene);
  return std::make_shared<const haptics::Scene>(std::move(scene));
}

std::shared_ptr<const haptics::Scene> Stone() {
  return std::make_shared<const haptics::Scene>(haptics::Built(haptics::SceneOf(haptics::Sphere(5, 0.02))));
}

// The messages of a tick that pulls the n-th lump out at its top.
class Pull {
 public:
  Pull(const haptics::Scene& scene, std::uint32_t n, std::uint32_t stroke)
      : sculpt_session_(scene.live()->sculpt_session_at(n)), stroke_(stroke) {
    StrokeMessage begin;
    begin.kind = StrokeKind::kBegin;
    begin.stroke = stroke;
    begin.point_base_m = {0.05 * n, 0, kRadius_m};
    begin.brush = sculpt_session_.brush();
    Send(begin);
  }
  void To(double offset_m) {
    StrokeMessage move;
    move.stroke = stroke_;
    move.offset_m = offset_m;
    Send(move);
  }
  void End() {
    StrokeMessage end;
    end.kind = StrokeKind::kEnd;
    end.stroke = stroke_;
    Send(end);
  }

 private:
  void Send(const StrokeMessage& message) {
    EXPECT_TRUE(InTime([&] { return sculpt_session_.ring().TryPush(message); }));
  }
  haptics::sculpt::SculptSession& sculpt_session_;
  std::uint32_t stroke_;
};

// Height of the top of the n-th lump as the tick sees it.
double Top(const haptics::Scene& scene, std::uint32_t n = 0) {
  const haptics::sculpt::SculptTable* table = scene.live()->sculpt_session_at(n).Acquire();
  const base::Vec3 above{0.05 * n, 0, 0.1};
  const auto nearest = haptics::NearestInTree(haptics::sculpt::SculptSurface(*table), 0, above);
  return nearest.triangle == haptics::kNoIndex ? 0 : nearest.closest.point.z;
}

class SculptThreadTest : public testing::Test {
 protected:
  SculptAnswer Request(SculptAction action, const std::string& object = {}, std::uint64_t client = 0,
                       std::uint64_t owner = 0) {
    thread_.Request({.asker = 9, .number = ++number_, .client = client, .action = action, .object = object}, owner);
    std::optional<SculptAnswer> answer;
    EXPECT_TRUE(InTime([&] { return (answer = thread_.PopAnswer()).has_value(); }));
    if (!answer) return {};
    EXPECT_EQ(answer->asker, 9U);
    EXPECT_EQ(answer->number, number_);
    return std::move(*answer);
  }
  nlohmann::json Edits(const std::string& what, std::size_t n = 0) {
    return nlohmann::json::parse(Request(SculptAction::kEdits).text)["objects"][n][what];
  }
  void Begin(const std::shared_ptr<const haptics::Scene>& scene, std::uint64_t client = 1) {
    thread_.Add(client, "lumps.glb", scene);
    thread_.EnterScene(*scene);
  }
  // A finished stroke.
  void Stroke(const haptics::Scene& scene, std::uint32_t n, double offset_m) {
    const std::size_t before = Edits("strokes", n);
    Pull pull(scene, n, ++stroke_);
    pull.To(offset_m);
    pull.End();
    EXPECT_TRUE(InTime([&] { return Edits("strokes", n) == before + 1; }));
  }

  SculptThread thread_;
  std::uint32_t number_ = 0, stroke_ = 0;
};

TEST_F(SculptThreadTest, RunsOnlyWhileASculptableSceneExists) {
  EXPECT_FALSE(thread_.running());
  thread_.Add(1, "stone.glb", Stone());
  EXPECT_FALSE(thread_.running());
  for (int round = 0; round < 20; ++round) {
    const auto scene = Lumps(1);
    thread_.Add(1, "lumps.glb", scene);
    EXPECT_TRUE(thread_.running());
    if (round % 2 == 0) thread_.EnterScene(*scene);
    if (round % 3 == 0) {
      EXPECT_EQ(Edits("strokes"), 0);
    }
    thread_.LeaveScene(*scene);
    thread_.Remove(*scene);
    if (round % 4 == 0) {
      EXPECT_TRUE(InTime([&] { return !thread_.running(); }));
    }
    EXPECT_EQ(scene.use_count(), 1) << "it is released";
  }
}

TEST_F(SculptThreadTest, StrokeCanBeUndoneAndRedone) {
  const auto scene = Lumps(1);
  Begin(scene);
  Stroke(*scene, 0, 0.003);
  EXPECT_TRUE(InTime([&] { return Top(*scene) > kRadius_m + 0.0025; }));
  SculptAnswer answer = Request(SculptAction::kUndo);
  EXPECT_TRUE(answer.ok) << answer.text;
  EXPECT_NE(answer.text.find("0 to undo, 1 to redo"), std::string::npos) << answer.text;
  EXPECT_TRUE(InTime([&] { return Top(*scene) < kRadius_m + 1e-6; }));
  answer = Request(SculptAction::kUndo);
  EXPECT_FALSE(answer.ok);
  EXPECT_EQ(answer.text, "lump 0: nothing to undo");
  EXPECT_TRUE(Request(SculptAction::kRedo).ok);
  EXPECT_TRUE(InTime([&] { return Top(*scene) > kRadius_m + 0.0025; }));
  EXPECT_EQ(Request(SculptAction::kRedo).text, "lump 0: nothing to redo");
}

TEST_F(SculptThreadTest, RejectsUndoAndRedoDuringAStroke) {
  const auto scene = Lumps(1);
  Begin(scene);
  Pull pull(*scene, 0, 1);
  pull.To(0.002);
  ASSERT_TRUE(InTime([&] { return Edits("stroke_open") == true; }));
  for (const SculptAction action : {SculptAction::kUndo, SculptAction::kRedo}) {
    const SculptAnswer answer = Request(action);
    EXPECT_FALSE(answer.ok);
    EXPECT_NE(answer.text.find("a stroke is open; lift the pen"), std::string::npos) << answer.text;
  }
  thread_.LeaveScene(*scene);  // its end will not come
  EXPECT_EQ(Edits("stroke_open"), false);
  EXPECT_EQ(Edits("strokes"), 1) << "finished edits stay";
  EXPECT_GT(Top(*scene), kRadius_m + 0.0015);
  EXPECT_TRUE(Request(SculptAction::kUndo).ok) << "also while the tick does not use it";
  EXPECT_LT(Top(*scene), kRadius_m + 1e-6);
}

TEST_F(SculptThreadTest, ReleasesWhatIsHeld) {
  const auto scene = Lumps(2);
  Begin(scene);
  SculptAnswer answer = Request(SculptAction::kRelease);
  EXPECT_FALSE(answer.ok);
  EXPECT_EQ(answer.text, "nothing is held");
  Pull pull(*scene, 1, 1);
  ASSERT_TRUE(InTime([&] { return Edits("stroke_open", 1) == true; }));
  const std::uint32_t before = scene->live()->sculpt_session_at(1).releases();
  answer = Request(SculptAction::kRelease);
  EXPECT_TRUE(answer.ok);
  EXPECT_EQ(answer.text, "lump 1: released");
  EXPECT_EQ(scene->live()->sculpt_session_at(0).releases(), 0U);
  EXPECT_EQ(scene->live()->sculpt_session_at(1).releases(), before + 1) << "for the tick to see";
}

TEST_F(SculptThreadTest, UndoDefaultsToTheObjectEditedLast) {
  const auto scene = Lumps(3);
  Begin(scene);
  Stroke(*scene, 2, 0.002);
  Stroke(*scene, 0, 0.002);
  EXPECT_EQ(Request(SculptAction::kUndo, "lump 2").text.substr(0, 15), "lump 2: undone,");
  EXPECT_EQ(Request(SculptAction::kRedo, "2").text.substr(0, 15), "lump 2: redone,");
  EXPECT_EQ(Request(SculptAction::kUndo).text.substr(0, 15), "lump 2: undone,") << "edited last";
  EXPECT_EQ(Request(SculptAction::kUndo, "lump 1").text, "lump 1: nothing to undo");
  const SculptAnswer unknown = Request(SculptAction::kUndo, "vase");
  EXPECT_FALSE(unknown.ok);
  EXPECT_NE(unknown.text.find("\"vase\""), std::string::npos);
  EXPECT_NE(unknown.text.find("\"lump 1\" (1)"), std::string::npos) << unknown.text;
}

TEST_F(SculptThreadTest, SceneDefaultsToTheOwnersOrTheOnlyOne) {
  EXPECT_NE(Request(SculptAction::kUndo).text.find("no application has a scene with a sculptable object"),
            std::string::npos);
  const auto first = Lumps(1), second = Lumps(2);
  thread_.Add(1, "first.glb", first);
  EXPECT_EQ(nlohmann::json::parse(Request(SculptAction::kEdits, {}, 0, 7).text)["client"], 1) << "the only one";
  thread_.Add(2, "second.glb", second);
  EXPECT_EQ(nlohmann::json::parse(Request(SculptAction::kEdits, {}, 0, 2).text)["scene"], "second.glb")
      << "the owner's";
  EXPECT_EQ(nlohmann::json::parse(Request(SculptAction::kEdits, {}, 1, 2).text)["scene"], "first.glb")
      << "the named one";
  EXPECT_NE(Request(SculptAction::kEdits).text.find("choose a client: 1, 2"), std::string::npos);
  EXPECT_NE(Request(SculptAction::kEdits, {}, 5).text.find("client 5 has no sculpted scene"), std::string::npos);
}

// Also while the second stroke goes on: clay that is held is saved as it is.
TEST_F(SculptThreadTest, SavedFileMatchesTheSculptedSurface) {
  const auto scene = Lumps(2);
  Begin(scene);
  Stroke(*scene, 1, 0.002);
  Pull pull(*scene, 1, ++stroke_);
  pull.To(0.002);
  ASSERT_TRUE(InTime([&] { return Top(*scene, 1) > kRadius_m + 0.003; }));
  const SculptAnswer answer = Request(SculptAction::kSave);
  ASSERT_TRUE(answer.ok) << answer.text;
  ASSERT_GT(answer.file_bytes, 0U);
  std::string bytes(answer.file_bytes, '\0');
  ASSERT_EQ(::pread(answer.file.get(), bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
  EXPECT_EQ(::mmap(nullptr, bytes.size(), PROT_WRITE, MAP_SHARED, answer.file.get(), 0), MAP_FAILED) << "sealed";
  const test::TempFolder folder;
  scene::LoadReport report;
  const auto loaded = scene::LoadSceneFile(folder.Write("saved.glb", bytes), {}, report);
  ASSERT_TRUE(loaded.ok()) << loaded.error();
  EXPECT_TRUE(report.warnings.empty());
  ASSERT_EQ(loaded->objects.size(), 2U);
  double top_m = 0;
  for (const base::Vec3& v : loaded->objects[1].vertices_base_m) top_m = std::max(top_m, v.z);
  EXPECT_NEAR(top_m, Top(*scene, 1), 1e-6);
  EXPECT_TRUE(loaded->materials[0].sculpt.enabled);
}

TEST_F(SculptThreadTest, ReportsRepeatedStrokeErrorsOnce) {
  const auto scene = Lumps(1);
  Begin(scene);
  StrokeMessage begin;
  begin.kind = StrokeKind::kBegin;
  begin.point_base_m = {0, 0, 0.05};  // in the air
  begin.brush = scene->live()->sculpt_session_at(0).brush();
  for (std::uint32_t k = 1; k <= 50; ++k) {
    begin.stroke = k;
    ASSERT_TRUE(InTime([&] { return scene->live()->sculpt_session_at(0).ring().TryPush(begin); }));
    if (k % 10 == 0) std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  std::optional<SculptProblem> problem;
  ASSERT_TRUE(InTime([&] { return (problem = thread_.PopProblem()).has_value(); }));
  EXPECT_EQ(problem->client, 1U);
  EXPECT_NE(problem->text.find("lumps.glb: lump 0: sculpting: no surface"), std::string::npos) << problem->text;
  Stroke(*scene, 0, 0.002);  // all before it were handled
  for (int k = 0; k < 100; ++k) EXPECT_FALSE(thread_.PopProblem());
}

TEST_F(SculptThreadTest, RejectsRequestsBeyondTheQueueLimit) {
  const auto scene = Lumps(1);
  thread_.Add(1, "lumps.glb", scene);
  std::size_t refused = 0, answered = 0;
  for (int k = 0; k < 500; ++k) thread_.Request({.asker = 3, .action = SculptAction::kSave}, 0);
  ASSERT_TRUE(InTime([&] {
    while (const auto answer = thread_.PopAnswer()) {
      ++answered;
      refused += !answer->ok;
    }
    return answered == 500;
  }));
  EXPECT_GT(refused, 0U);
  EXPECT_LT(refused, 500U);
}

// Sanitizers watch. A tick that walks the surface all the time, while strokes are made and undone, and the scene
// comes and goes.
TEST_F(SculptThreadTest, TickSeesConsistentSurfaceDuringEdits) {
  const auto scene = Lumps(1);
  thread_.Add(1, "lumps.glb", scene);
  haptics::Random random(11);
  for (int round = 0; round < 12; ++round) {
    thread_.EnterScene(*scene);
    std::atomic<bool> stop{false};
    std::atomic<std::uint64_t> walks{0};
    std::thread tick([&] {
      std::uint64_t generation = 0;
      while (!stop.load(std::memory_order_acquire)) {
        const haptics::sculpt::SculptTable* table = scene->live()->sculpt_session_at(0).Acquire();
        EXPECT_GE(table->generation, generation);
        generation = table->generation;
        const haptics::sculpt::SculptSurface surface(*table);
        double farthest_m = 0;
        for (std::uint32_t page = 0; page < surface.page_count(); ++page) {
          for (std::uint32_t slot = 0; slot < haptics::sculpt::kPageTriangles; ++slot) {
            const std::uint32_t t = haptics::sculpt::IndexOf(page, slot);
            if (!surface.IsLive(t)) continue;
            for (const base::Vec3& corner : surface.TriangleCorners(t)) {
              farthest_m = std::max(farthest_m, std::hypot(corner.x, corner.y, corner.z));
            }
          }
        }
        EXPECT_TRUE(farthest_m > 0.9 * kRadius_m && farthest_m < 3 * kRadius_m) << farthest_m;
        walks.fetch_add(1, std::memory_order_relaxed);
      }
    });
    for (int k = 0; k < 6; ++k) {
      Pull pull(*scene, 0, ++stroke_);
      pull.To(random.Uniform(-0.002, 0.003));
      if (k % 2 == 0) pull.End();
      if (k % 3 == 0) Request(random.Uniform(0, 1) < 0.5 ? SculptAction::kUndo : SculptAction::kRedo);
    }
    EXPECT_TRUE(InTime([&] { return walks.load() > 3; }));
    stop.store(true, std::memory_order_release);  // the tick no longer uses the scene ...
    tick.join();
    thread_.LeaveScene(*scene);  // ... and only then this
    if (round % 3 == 0) Request(SculptAction::kUndo);
  }
  thread_.Remove(*scene);
}

}  // namespace test_daemon_sculpt
}  // namespace omni::daemon
