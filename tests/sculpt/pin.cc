// A drawing thread pins generations while an editor publishes and a tick reads: every one is complete, the editor goes
// on, and memory of unpinned ones is reused. Made to be run under ThreadSanitizer.
#include <gtest/gtest.h>

#include <atomic>
#include <cstring>
#include <thread>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_pin {

// One stroke somewhere, sometimes taken back.
void Edit(SculptEditor& editor, Random& random, int k) {
  Brush brush;
  brush.radius_m = random.Uniform(0.003, 0.008);
  (void)editor.Stroke(On(editor, random.InBox(0.05)), brush, random.Uniform(-0.002, 0.002));
  if (k % 3 == 2) editor.Undo();
}

TEST(SculptPin, PinnedGenerationsAreCompleteWhileATickReads) {
  const auto editor = EditorOf(BumpyBall(12, 0.03));
  SculptPublisher& publisher = editor->publisher();
  editor->Publish();
  publisher.SetReader(true);
  std::atomic<bool> stop{false};
  std::thread tick([&] {
    while (!stop.load(std::memory_order_relaxed)) (void)publisher.Acquire();
  });
  std::uint64_t seen = 0, backwards = 0, broken = 0;
  std::thread drawing([&] {
    std::uint64_t last = 0;
    while (!stop.load(std::memory_order_relaxed)) {
      const SculptTable* table = publisher.Pin();
      backwards += table->generation < last;
      if (table->generation != last) {
        ++seen;
        broken += !CheckManifold(SculptSurface(*table)).ok();
      }
      last = table->generation;
      publisher.Unpin();
    }
  });
  Random random(10);
  std::uint64_t published = 0;
  for (int k = 0; k < 300; ++k) {
    Edit(*editor, random, k);
    published += editor->Publish().published;
  }
  stop = true;
  tick.join();
  drawing.join();
  publisher.SetReader(false);
  EXPECT_GT(published, 0U);
  EXPECT_GT(seen, 1U);
  EXPECT_EQ(backwards, 0U);
  EXPECT_EQ(broken, 0U);
}

// A pin that is held keeps its generation, bit by bit, whatever is edited; the editor collects meanwhile.
TEST(SculptPin, AHeldPinKeepsItsGeneration) {
  const auto editor = EditorOf(BumpyBall(8, 0.03));
  SculptPublisher& publisher = editor->publisher();
  editor->Publish();
  const SculptTable* pinned = publisher.Pin();
  ASSERT_NE(pinned, nullptr);
  std::vector<PageContent> content;
  for (const Page* page : pinned->pages) content.push_back(page->content);
  Random random(4);
  std::uint64_t refused = 0;
  for (int k = 0; k < 60; ++k) {
    Edit(*editor, random, k);
    refused += !editor->Publish().published;
  }
  EXPECT_GT(refused, 0U) << "with one generation pinned there is no room for more than kMaxTables";
  EXPECT_EQ(publisher.OldestInUse(), pinned->generation);
  for (std::size_t k = 0; k < content.size(); ++k) {
    ASSERT_EQ(std::memcmp(&content[k], &pinned->pages[k]->content, sizeof(PageContent)), 0);
  }
  publisher.Unpin();
  EXPECT_TRUE(editor->Publish().published) << "all that was collected goes out at once";
  EXPECT_EQ(publisher.OldestInUse(), publisher.generation());
}

TEST(SculptPin, PinReturnsNullBeforeFirstPublish) {
  SculptPublisher publisher;
  EXPECT_EQ(publisher.Pin(), nullptr);
  publisher.Unpin();
  EXPECT_EQ(publisher.OldestInUse(), 0U);
}

}  // namespace test_sculpt_pin
}  // namespace omni::haptics::sculpt
