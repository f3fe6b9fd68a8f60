// Edits that one editor logged, taken over by another: the same surface to the bit, undo and redo included, and no
// bytes can make an editor unusable.
#include <gtest/gtest.h>

#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_history {

constexpr double kRadius_m = 0.03;

class Logged {
 public:
  Logged() : editor(EditorOf(BumpyBall(10, kRadius_m))) {
    editor->SetLog([this](EditKind kind, const UndoStep& step) {
      if (kind == EditKind::kUndo) --history.done;
      if (kind == EditKind::kRedo) ++history.done;
      if (kind != EditKind::kStroke) return;
      history.steps.resize(history.done++);
      history.steps.push_back(step);
    });
  }
  void Stroke(Random& random) {
    Brush brush;
    brush.radius_m = random.Uniform(0.004, 0.015);
    ASSERT_TRUE(editor->Stroke(On(*editor, random.InBox(kRadius_m)), brush, random.Uniform(-0.004, 0.006)).ok());
    editor->Publish();
  }
  // Some strokes, undone and redone.
  void Play(Random& random, int edits) {
    for (int k = 0; k < edits; ++k) {
      const double what = random.Uniform(0, 1);
      if (what < 0.2) {
        editor->Undo();
      } else if (what < 0.35) {
        editor->Redo();
      } else {
        Stroke(random);
      }
    }
  }

  std::unique_ptr<SculptEditor> editor;
  EditHistory history;
};

TEST(SculptHistory, RestoredEditorHasTheSameSurfaceAndGoesOnAlike) {
  for (std::uint64_t seed = 1; seed <= 5; ++seed) {
    Random random(seed);
    Logged first;
    const auto second = EditorOf(BumpyBall(10, kRadius_m));
    EXPECT_EQ(first.editor->mesh().Hash(), second->mesh().Hash()) << "equal meshes begin alike";
    first.Play(random, 30);
    const base::Status restored = second->Restore(first.history);
    ASSERT_TRUE(restored.ok()) << restored.error();
    second->Publish();
    EXPECT_EQ(first.editor->mesh().Hash(), second->mesh().Hash());
    EXPECT_EQ(first.editor->undo_steps(), second->undo_steps());
    EXPECT_EQ(first.editor->redo_steps(), second->redo_steps());
    EXPECT_EQ(first.editor->undo_bytes(), second->undo_bytes());
    while (first.editor->Undo()) {
      ASSERT_TRUE(second->Undo());
      ASSERT_EQ(first.editor->mesh().Hash(), second->mesh().Hash());
    }
    EXPECT_FALSE(second->Undo());
    while (first.editor->Redo()) {
      ASSERT_TRUE(second->Redo());
    }
    EXPECT_EQ(first.editor->mesh().Hash(), second->mesh().Hash());
    // And what the second one goes on to do is again a history of the same mesh.
    EditHistory longer = first.history;
    longer.done = longer.steps.size();
    second->SetLog([&](EditKind, const UndoStep& step) { longer.steps.push_back(step), ++longer.done; });
    Brush brush;
    ASSERT_TRUE(second->Stroke(On(*second, random.InBox(kRadius_m)), brush, 0.003).ok());
    const auto third = EditorOf(BumpyBall(10, kRadius_m));
    ASSERT_TRUE(third->Restore(longer).ok());
    EXPECT_EQ(second->mesh().Hash(), third->mesh().Hash());
  }
}

TEST(SculptHistory, OpenStrokeCanBeKeptAsItIs) {
  Random random(4);
  Logged first;
  first.Play(random, 5);
  EXPECT_TRUE(first.editor->OpenStep().words.empty());
  Brush brush;
  brush.radius_m = 0.01;
  ASSERT_TRUE(first.editor->Begin(On(*first.editor, {0, 0, kRadius_m}), brush).ok());
  for (int k = 1; k <= 3; ++k) {
    first.editor->MoveTo(1e-3 * k);
    EditHistory history = first.history;
    history.steps.resize(history.done++);
    history.steps.push_back(first.editor->OpenStep());
    const auto second = EditorOf(BumpyBall(10, kRadius_m));
    ASSERT_TRUE(second->Restore(history).ok());
    EXPECT_EQ(first.editor->mesh().Hash(), second->mesh().Hash());
  }
  // The end takes out vertices that the form does not need, and moves nothing.
  EditHistory history = first.history;
  history.steps.resize(history.done++);
  history.steps.push_back(first.editor->OpenStep());
  const auto second = EditorOf(BumpyBall(10, kRadius_m));
  ASSERT_TRUE(second->Restore(history).ok());
  first.editor->End();
  EXPECT_LE(first.editor->mesh().triangle_count(), second->mesh().triangle_count());
  for (int k = 0; k < 500; ++k) {
    const Vec3 on = On(*second, random.InBox(2 * kRadius_m)).position;
    EXPECT_LT(Norm(On(*first.editor, on).position - on), 1e-5);  // each vertex 4 um
  }
}

TEST(SculptHistory, SumOfStepsIsAllOfThem) {
  Random random(9);
  Logged first;
  for (int k = 0; k < 12; ++k) first.Stroke(random);
  StepSum sum;
  for (std::size_t i = 0; i < 7; ++i) sum.Add(first.history.steps[i]);
  EditHistory shorter{sum.Take(), {first.history.steps.begin() + 7, first.history.steps.end()}, 5};
  const auto second = EditorOf(BumpyBall(10, kRadius_m));
  ASSERT_TRUE(second->Restore(shorter).ok());
  EXPECT_EQ(first.editor->mesh().Hash(), second->mesh().Hash());
  EXPECT_EQ(second->undo_steps(), 5U);
}

// Any words: they are refused, and then nothing has changed, or they lead to a sound surface. Sanitizers watch.
TEST(SculptHistory, DamagedStepsAreRefusedOrLeadToASoundSurface) {
  Random random(12);
  Logged first;
  for (int k = 0; k < 4; ++k) first.Stroke(random);
  const std::uint64_t rest = EditorOf(BumpyBall(10, kRadius_m))->mesh().Hash();
  int refused = 0;
  for (int round = 0; round < 150; ++round) {
    EditHistory history = first.history;
    const auto at = static_cast<std::size_t>(random.Uniform(0, 4));
    std::vector<std::uint64_t>& words = history.steps[at].words;
    for (int k = 0; k < 1 + round % 3; ++k) {
      const auto word = static_cast<std::size_t>(random.Uniform(0, static_cast<double>(words.size())));
      words[word] ^= std::uint64_t{1} << static_cast<int>(random.Uniform(0, 64));
    }
    if (round % 10 == 9) words.resize(words.size() / 2);
    const auto second = EditorOf(BumpyBall(10, kRadius_m));
    if (!second->Restore(history).ok()) {
      ++refused;
      ASSERT_EQ(second->mesh().Hash(), rest);
    }
    second->Publish();
    while (second->Undo()) second->Publish();
    const ManifoldReport manifold = CheckManifold(second->mesh());
    ASSERT_TRUE(manifold.ok()) << manifold.problem;
    Brush brush;
    brush.radius_m = 0.01;
    static_cast<void>(second->Stroke(On(*second, {0, 0, kRadius_m}), brush, 0.002));
    second->Publish();
  }
  EXPECT_GT(refused, 30);
}

// Bytes beyond what the checks of a surface look at: object, material, component, place, links between pages.
TEST(SculptHistory, ValuesOutOfRangeAreRefused) {
  const auto refused = [](auto change) {
    const auto editor = EditorOf(BumpyBall(10, kRadius_m));
    const PageContent before = editor->mesh().GetPage(0).content;
    PageContent after = before;
    change(after);
    EditHistory history;
    AppendRuns(0, before, after, history.base);
    return !editor->Restore(history).ok();
  };
  EXPECT_FALSE(refused([](PageContent&) {}));
  EXPECT_TRUE(refused([](PageContent& page) { page.triangle[3].material = 1; }));
  EXPECT_TRUE(refused([](PageContent& page) { page.triangle[3].object = 1; }));
  EXPECT_TRUE(refused([](PageContent& page) { page.triangle[3].component = 1; }));
  EXPECT_TRUE(refused([](PageContent& page) { page.vertex[3].x = std::nan(""); }));
  EXPECT_TRUE(refused([](PageContent& page) { page.vertex[3].x = 11; }));
  EXPECT_TRUE(refused([](PageContent& page) { page.vertex_used[2] |= std::uint64_t{1} << 40; }));
  EXPECT_TRUE(refused([](PageContent& page) { ++page.vertex_count; }));
  EXPECT_TRUE(refused([](PageContent& page) { ++page.triangle_count; }));
  EXPECT_TRUE(refused([](PageContent& page) { page.spill = 0; }));
  EXPECT_TRUE(refused([](PageContent& page) { page.spill = 1u << 20; }));
  EXPECT_TRUE(refused([](PageContent& page) { page.first_triangle[0] = 1u << 30; }));
  EXPECT_TRUE(refused([](PageContent& page) { page.triangle[0].neighbour[1] ^= 1; }));
}

}  // namespace test_sculpt_history
}  // namespace omni::haptics::sculpt
