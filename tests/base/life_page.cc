// Signs of life as the reader of the page dates them.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <cerrno>
#include <limits>
#include <random>

#include "service/base/life_page.h"
#include "service/base/sealed_memory.h"

namespace omni::base {
namespace test_base_life_page {

constexpr std::int64_t kMs_ns = 1'000'000;
constexpr std::int64_t kAges_ns = 1'000'000'000'000'000;  // longer than any limit

TEST(LifeWatch, BeatIsDatedAtThePreviousLook) {
  LifePage page;
  LifeWatch watch;
  watch.Update(page, 100 * kMs_ns);
  page.SignalAlive(101 * kMs_ns);
  watch.Update(page, 300 * kMs_ns);
  EXPECT_EQ(watch.Silence_ns(300 * kMs_ns), 200 * kMs_ns) << "it may be that old";
  watch.Update(page, 310 * kMs_ns);
  EXPECT_EQ(watch.Silence_ns(310 * kMs_ns), 210 * kMs_ns);
}

TEST(LifeWatch, FirstLookFindsNoSignOfLife) {
  LifePage page;
  page.SignalAlive(100 * kMs_ns);
  LifeWatch watch;
  EXPECT_GT(watch.Silence_ns(100 * kMs_ns), kAges_ns);
  watch.Update(page, 100 * kMs_ns);
  EXPECT_GT(watch.Silence_ns(100 * kMs_ns), kAges_ns);
}

TEST(LifeWatch, ClientWithoutStampsIsDatedByItsBeats) {
  LifePage page;
  LifeWatch watch;
  watch.Update(page, 100 * kMs_ns);
  page.beat.fetch_add(1);
  watch.Update(page, 101 * kMs_ns);
  EXPECT_EQ(watch.Silence_ns(101 * kMs_ns), kMs_ns);
}

TEST(LifeWatch, StampMakesBeatOlder) {
  LifePage page;
  LifeWatch watch;
  watch.Update(page, 100 * kMs_ns);
  page.SignalAlive(40 * kMs_ns);
  watch.Update(page, 101 * kMs_ns);
  EXPECT_EQ(watch.Silence_ns(101 * kMs_ns), 61 * kMs_ns);
}

// A hostile page: any numbers at any time. The watch never finds it younger than the look before its last change.
TEST(LifeWatch, AnyContentIsNeverYoungerThanThePreviousLook) {
  std::mt19937_64 random(5);
  LifePage page;
  LifeWatch watch;
  std::int64_t now_ns = 1'000 * kMs_ns, before_ns = 0, changed_after_ns = std::numeric_limits<std::int64_t>::min();
  for (int i = 0; i < 100'000; ++i) {
    if (random() % 4 == 0) {
      page.stamp_ns = random() % 3 == 0 ? random() : static_cast<std::uint64_t>(now_ns + 1'000'000 * kMs_ns);
      const std::uint64_t beat = random() % 2 == 0 ? random() : page.beat + 1;
      if (beat != page.beat && i > 0) changed_after_ns = before_ns;
      page.beat = beat;
    }
    watch.Update(page, now_ns);
    ASSERT_GE(watch.Silence_ns(now_ns), StampDifference_ns(now_ns, changed_after_ns));
    before_ns = now_ns;
    now_ns += static_cast<std::int64_t>(random() % (20 * kMs_ns));
  }
}

// What its client can do to the memory of a life page: neither truncation nor a hole raises a signal in the reader.
TEST(LifePage, SealedMemoryStaysReadableWhateverItsClientDoes) {
  auto memory = MakeSealedMemory("omni-life", 4096, PROT_READ, kSealsFixedSize);
  ASSERT_TRUE(memory.ok()) << memory.error();
  const auto* page = static_cast<const LifePage*>(memory->mapping.get());
  auto mapping = MapSealed(memory->fd.get(), kSealsFixedSize, 4096, PROT_READ | PROT_WRITE);
  ASSERT_TRUE(mapping.ok()) << mapping.error();
  static_cast<LifePage*>(mapping->get())->SignalAlive(7);
  EXPECT_EQ(page->beat.load(), 1U);
  EXPECT_EQ(ftruncate(memory->fd.get(), 0), -1);
  EXPECT_EQ(errno, EPERM);
  ASSERT_EQ(fallocate(memory->fd.get(), FALLOC_FL_PUNCH_HOLE | FALLOC_FL_KEEP_SIZE, 0, 4096), 0);
  EXPECT_EQ(page->beat.load(), 0U);
  LifeWatch watch;
  watch.Update(*page, kMs_ns);
  EXPECT_GT(watch.Silence_ns(kMs_ns), kAges_ns);
}

}  // namespace test_base_life_page
}  // namespace omni::base
