// COBS: the vectors of the paper, and resynchronisation of a stream.
#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "firmware/wire/cobs.h"
#include "firmware/wire/messages.h"

namespace omni::wire {
namespace test_wire_cobs_unit {

using Bytes = std::vector<std::uint8_t>;

Bytes Encoded(const Bytes& data) {
  Bytes packet(CobsSizeMax(data.size()));
  packet.resize(CobsEncode(data.data(), data.size(), packet.data(), packet.size()));
  return packet;
}

// All packets that come out of `stream`.
std::vector<Bytes> Received(const Bytes& stream, CobsReceiver& receiver) {
  std::vector<Bytes> packets;
  for (const std::uint8_t byte : stream) {
    if (receiver.Push(byte)) packets.emplace_back(receiver.data(), receiver.data() + receiver.size());
  }
  return packets;
}

Bytes Counting(int first, int count) {
  Bytes bytes(static_cast<std::size_t>(count));
  std::iota(bytes.begin(), bytes.end(), static_cast<std::uint8_t>(first));
  return bytes;
}

Bytes Joined(std::initializer_list<Bytes> parts) {
  Bytes all;
  for (const Bytes& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

struct Vector {
  const char* name;
  Bytes data, packet;
};

std::vector<Vector> KnownVectors() {
  const Bytes all = Counting(1, 254);
  return {
      // The example of the paper, figure 3: the first bytes of an IP packet.
      {"paper",
       {0x45, 0, 0, 0x2C, 0x4C, 0x79, 0, 0, 0x40, 0x06, 0x4F, 0x37},
       {0x02, 0x45, 0x01, 0x04, 0x2C, 0x4C, 0x79, 0x01, 0x05, 0x40, 0x06, 0x4F, 0x37}},
      {"empty", {}, {1}},
      {"zero", {0}, {1, 1}},
      {"two zeros", {0, 0}, {1, 1, 1}},
      {"zero, byte, zero", {0, 0x11, 0}, {1, 2, 0x11, 1}},
      {"bytes and a zero", {0x11, 0x22, 0, 0x33}, {3, 0x11, 0x22, 2, 0x33}},
      {"no zero", {0x11, 0x22, 0x33, 0x44}, {5, 0x11, 0x22, 0x33, 0x44}},
      {"zeros at the end", {0x11, 0, 0, 0}, {2, 0x11, 1, 1, 1}},
      {"one full block", all, Joined({{255}, all})},
      {"a zero, then a full block", Joined({{0}, all}), Joined({{1, 255}, all})},
      {"a full block, then a byte", Joined({all, {255}}), Joined({{255}, all, {2, 255}})},
      {"a full block, then a zero", Joined({Counting(2, 254), {0}}), Joined({{255}, Counting(2, 254), {1, 1}})},
      {"a block that lacks one, then a zero and a byte", Joined({Counting(3, 253), {0, 1}}),
       Joined({{254}, Counting(3, 253), {2, 1}})},
  };
}

TEST(Cobs, MatchesKnownVectors) {
  for (const Vector& vector : KnownVectors()) {
    EXPECT_EQ(Encoded(vector.data), vector.packet) << vector.name;
    CobsReceiver receiver;
    EXPECT_EQ(Received(Joined({vector.packet, {kCobsEnd}}), receiver), std::vector<Bytes>{vector.data}) << vector.name;
  }
}

// Other encoders write an empty block at the end of the data, which may be omitted.
TEST(Cobs, AcceptsAnEmptyBlockAfterAFullOne) {
  const Bytes all = Counting(1, 254);
  CobsReceiver receiver;
  EXPECT_EQ(Received(Joined({{255}, all, {1, kCobsEnd}}), receiver), std::vector<Bytes>{all});
}

TEST(Cobs, RejectsSmallBuffersWithoutOverrun) {
  for (const Vector& vector : KnownVectors()) {
    for (std::size_t capacity = 0; capacity < vector.packet.size(); ++capacity) {
      Bytes packet(capacity + 1, 0xAA);
      EXPECT_EQ(CobsEncode(vector.data.data(), vector.data.size(), packet.data(), capacity), 0U) << vector.name;
      EXPECT_EQ(packet[capacity], 0xAA) << vector.name;
    }
  }
}

TEST(Cobs, IgnoresZerosBetweenPackets) {
  CobsReceiver receiver;
  EXPECT_EQ(Received({0, 0, 2, 7, 0, 0, 0, 2, 8, 0}, receiver), (std::vector<Bytes>{{7}, {8}}));
  EXPECT_EQ(receiver.cut_short() + receiver.too_long(), 0U);
}

TEST(Cobs, CountsTruncatedPacketsAndReceivesTheNext) {
  CobsReceiver receiver;
  EXPECT_EQ(Received({5, 1, 2, 0, 2, 9, 0}, receiver), std::vector<Bytes>{{9}});
  EXPECT_EQ(receiver.cut_short(), 1U);
}

TEST(Cobs, CountsOverlongPacketsAndReceivesTheNext) {
  CobsReceiver receiver;
  const Bytes longest(kFrameSizeMax, 7);
  const Bytes longer(kFrameSizeMax + 1, 7);
  const Bytes zeros(kFrameSizeMax + 1, 1);  // 512 empty blocks: 511 zeros
  EXPECT_EQ(Received(Joined({Encoded(longest), {0}, Encoded(longer), {0}, zeros, {0, 2, 9, 0}}), receiver),
            (std::vector<Bytes>{longest, Bytes(kFrameSizeMax, 0), {9}}));
  EXPECT_EQ(receiver.too_long(), 1U);
  EXPECT_EQ(Received(Joined({Bytes(100'000, 255), {0, 2, 9, 0}}), receiver), std::vector<Bytes>{{9}});
  EXPECT_EQ(receiver.too_long(), 2U);
  EXPECT_EQ(receiver.cut_short(), 0U);
}

Bytes TelemetryFrame(std::uint16_t seq) {
  Telemetry telemetry;
  telemetry.field[3][1] = static_cast<std::int16_t>(seq * 3);
  Bytes frame(kFrameSizeMax);
  frame.resize(Encode(telemetry, seq, 1000U * seq, frame.data(), frame.size()).size);
  return frame;
}

// Whatever value one byte of the middle frame changes to, no wrong frame is accepted, and the frames around it survive;
// only a damaged end costs two.
TEST(Cobs, CorruptByteLosesOnlyTheFramesItTouches) {
  const Bytes frames[3] = {TelemetryFrame(1), TelemetryFrame(2), TelemetryFrame(3)};
  const Bytes first = Joined({Encoded(frames[0]), {kCobsEnd}});
  const Bytes middle = Joined({Encoded(frames[1]), {kCobsEnd}});
  const Bytes last = Joined({Encoded(frames[2]), {kCobsEnd}});
  for (std::size_t at = 0; at < middle.size(); ++at) {
    const bool is_end = at + 1 == middle.size();
    for (int value = 0; value < 256; ++value) {
      if (middle[at] == value) continue;
      Bytes damaged = middle;
      damaged[at] = static_cast<std::uint8_t>(value);
      CobsReceiver receiver;
      std::vector<Bytes> good;
      for (const Bytes& packet : Received(Joined({first, damaged, last}), receiver)) {
        FrameView view;
        if (OpenFrame(packet.data(), packet.size(), view) == Status::kOk) good.push_back(packet);
      }
      const std::vector<Bytes> expected = is_end ? std::vector<Bytes>{frames[0]} : std::vector{frames[0], frames[2]};
      ASSERT_EQ(good, expected) << "byte " << at << " is " << value;
    }
  }
}

}  // namespace test_wire_cobs_unit
}  // namespace omni::wire
