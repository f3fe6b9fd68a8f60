// The seqlock under a writer at full speed: on one mapping, so that a thread sanitizer sees both sides.
#include "service/protocol/state_memory.h"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "tests/support/same_bits.h"

namespace omni::protocol {
namespace test_protocol_seqlock {

using support::SameBits;

// Every field follows from one number, so that a mix of two samples shows.
ToolSample SampleOf(std::uint64_t n) {
  ToolSample sample;
  const auto x = static_cast<double>(n);
  sample.t_ns = static_cast<std::int64_t>(n);
  sample.flags = static_cast<std::uint32_t>(n);
  sample.position_base_m.fill(x);
  sample.orientation_base_wxyz.fill(-x);
  sample.linear_velocity_base_m_s.fill(x + 1);
  sample.angular_velocity_base_rad_s.fill(x + 2);
  sample.force_base_N.fill(x + 3);
  sample.position_sigma_m = x + 4;
  sample.gap_m = x + 5;
  return sample;
}

TEST(Seqlock, UnwrittenCellReadsAsNothing) {
  const RingSlot slot;
  ToolSample sample = SampleOf(3);
  EXPECT_EQ(LoadCell(slot, sample), 0u);
  EXPECT_TRUE(SameBits(sample, SampleOf(3)));
}

TEST(Seqlock, StoreThenLoad) {
  RingSlot slot;
  StoreCell(slot, SequenceOf(8), SampleOf(8));
  ToolSample sample;
  EXPECT_EQ(LoadCell(slot, sample), SequenceOf(8));
  EXPECT_TRUE(SameBits(sample, SampleOf(8)));
}

TEST(Seqlock, UnfinishedWriteReadsAsTorn) {
  RingSlot slot;
  StoreCell(slot, SequenceOf(8), SampleOf(8));
  slot.sequence.store(SequenceOf(9) - 1);
  ToolSample sample;
  EXPECT_EQ(LoadCell(slot, sample), 0u);
}

TEST(Seqlock, ReadersNeverSeeMixedValues) {
  const auto slot = std::make_unique<RingSlot>();
  std::atomic<bool> stop{false};
  std::atomic<std::uint64_t> wrong{0};
  std::vector<std::uint64_t> good(2, 0);
  std::vector<std::thread> readers;
  for (std::size_t r = 0; r < good.size(); ++r) {
    readers.emplace_back([&, r] {
      std::uint64_t newest = 0;
      for (bool last = false; !last;) {
        last = stop.load(std::memory_order_acquire);  // one more read of the cell at rest
        ToolSample sample;
        const std::uint64_t sequence = LoadCell(*slot, sample);
        if (sequence == 0) continue;
        const bool sound = sequence >= newest && SameBits(sample, SampleOf(sequence / 2 - 1));
        wrong += sound ? 0 : 1;
        newest = sequence;
        ++good[r];
      }
    });
  }
  for (std::uint64_t i = 0; i < 200'000; ++i) {
    StoreCell(*slot, SequenceOf(i), SampleOf(i));
    if (i % 4096 == 0) std::this_thread::yield();
  }
  stop.store(true, std::memory_order_release);
  for (std::thread& reader : readers) reader.join();
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(good[0], 0u);
  EXPECT_GT(good[1], 0u);
}

}  // namespace test_protocol_seqlock
}  // namespace omni::protocol
