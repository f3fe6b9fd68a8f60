// A tick reads while an editor publishes: every generation it sees is complete. Made to be run under ThreadSanitizer.
#include <gtest/gtest.h>

#include <thread>

#include "service/haptics/sculpt/mesh/check_manifold.h"
#include "service/haptics/sculpt/sculpt_query.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics::sculpt {
namespace test_sculpt_readers {

TEST(SculptReadersTest, ReaderSeesOnlyCompleteGenerations) {
  const auto editor = EditorOf(BumpyBall(12, 0.03));
  SculptPublisher& publisher = editor->publisher();
  publisher.SetReader(true);
  std::atomic<bool> stop{false};
  std::uint64_t seen = 0, backwards = 0, broken = 0, asked = 0;
  std::thread reader([&] {
    Random random(9);
    std::uint64_t last = 0;
    while (!stop.load(std::memory_order_relaxed)) {
      const SculptTable* table = publisher.Acquire();
      const SculptSurface surface(*table);
      backwards += surface.generation() < last;
      if (surface.generation() != last) {
        ++seen;
        broken += !CheckManifold(surface).ok();
      }
      last = surface.generation();
      const NearestResult nearest = NearestInTree(surface, 0, random.InBox(0.05));
      asked += surface.IsLive(nearest.triangle);
    }
  });
  Random random(10);
  Brush brush;
  std::uint64_t published = 0;
  for (int k = 0; k < 300; ++k) {
    brush.radius_m = random.Uniform(0.003, 0.008);
    (void)editor->Stroke(On(*editor, random.InBox(0.05)), brush, random.Uniform(-0.002, 0.002));
    if (k % 3 == 2) editor->Undo();
    published += editor->Publish().published;
  }
  // The reader must come to the newest, whatever was refused meanwhile.
  const std::uint64_t newest = publisher.generation();
  for (int k = 0; k < 5000 && publisher.OldestInUse() < newest; ++k) {
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }
  EXPECT_EQ(publisher.OldestInUse(), newest);
  stop = true;
  reader.join();
  publisher.SetReader(false);
  EXPECT_GT(published, 0U);
  EXPECT_GT(seen, 1U);
  EXPECT_GT(asked, 0U);
  EXPECT_EQ(backwards, 0U);
  EXPECT_EQ(broken, 0U);
}

}  // namespace test_sculpt_readers
}  // namespace omni::haptics::sculpt
