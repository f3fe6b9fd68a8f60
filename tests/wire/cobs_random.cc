// COBS over random data: round trips, however the stream is cut, and recovery from noise at the next delimiter.
#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

#include "firmware/wire/cobs.h"

namespace omni::wire {
namespace test_wire_cobs_property {

using Bytes = std::vector<std::uint8_t>;

// `zeros` of 256 bytes are zero: from dense to none.
Bytes RandomData(std::mt19937_64& random, std::size_t size_max) {
  Bytes data(random() % (size_max + 1));
  const auto zeros = random() % 3 == 0 ? 0U : static_cast<unsigned>(random() % 256);
  for (std::uint8_t& byte : data) {
    byte = static_cast<std::uint8_t>(random() % 256 < zeros ? 0 : 1 + random() % 255);
  }
  return data;
}

TEST(CobsProperty, RoundTripsOfRandomData) {
  std::mt19937_64 random(11);
  CobsReceiver receiver;
  for (int i = 0; i < 20'000; ++i) {
    const Bytes data = RandomData(random, kFrameSizeMax);
    Bytes packet(CobsSizeMax(data.size()));
    packet.resize(CobsEncode(data.data(), data.size(), packet.data(), packet.size()));
    ASSERT_GE(packet.size(), data.size() + 1);
    ASSERT_EQ(std::count(packet.begin(), packet.end(), kCobsEnd), 0);
    for (const std::uint8_t byte : packet) ASSERT_FALSE(receiver.Push(byte));
    ASSERT_TRUE(receiver.Push(kCobsEnd));
    ASSERT_EQ(Bytes(receiver.data(), receiver.data() + receiver.size()), data);
  }
  EXPECT_EQ(receiver.cut_short() + receiver.too_long(), 0U);
}

TEST(CobsProperty, ReceiverRecoversFromNoiseAtTheNextDelimiter) {
  std::mt19937_64 random(12);
  CobsReceiver receiver;
  for (int i = 0; i < 20'000; ++i) {
    for (std::uint64_t n = random() % 2000; n > 0; n -= std::min<std::uint64_t>(n, 8)) {
      const std::uint64_t noise = random();
      for (int byte = 0; byte < 8; ++byte) receiver.Push(static_cast<std::uint8_t>(noise >> (8 * byte)));
    }
    receiver.Push(kCobsEnd);
    const Bytes data = RandomData(random, 160);
    Bytes packet(CobsSizeMax(data.size()));
    packet.resize(CobsEncode(data.data(), data.size(), packet.data(), packet.size()));
    for (const std::uint8_t byte : packet) ASSERT_FALSE(receiver.Push(byte));
    ASSERT_TRUE(receiver.Push(kCobsEnd));
    ASSERT_EQ(Bytes(receiver.data(), receiver.data() + receiver.size()), data);
    ASSERT_LE(receiver.size(), kFrameSizeMax);
  }
  EXPECT_GT(receiver.cut_short(), 0U);
}

}  // namespace test_wire_cobs_property
}  // namespace omni::wire
