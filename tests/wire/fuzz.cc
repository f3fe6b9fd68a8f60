// No corrupted frame is ever accepted, whatever the corruption; no input ever reads outside its buffer (ASan watches).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <iterator>
#include <memory>
#include <numeric>
#include <random>
#include <string>
#include <vector>

#include "firmware/wire/messages.h"

namespace omni::wire {
namespace test_wire_fuzz {

constexpr float kCurrentMax_A = 15;

using Bytes = std::vector<std::uint8_t>;

Bytes RandomFrame(std::mt19937_64& random) {
  Bytes frame(kFrameSizeMax);
  Encoded encoded;
  const auto seq = static_cast<std::uint16_t>(random());
  if (random() % 2 == 0) {
    Telemetry telemetry;
    for (auto& sensor : telemetry.field) {
      for (std::int16_t& counts : sensor) counts = static_cast<std::int16_t>(random());
    }
    telemetry.saturated_mask = static_cast<std::uint32_t>(random()) & 0xFFFFFFU;
    telemetry.ack_host_us = random();
    encoded = Encode(telemetry, seq, random(), frame.data(), frame.size());
  } else {
    Command command;
    command.mode = Mode::kCurrent;
    for (float& set_point : command.set_point_A) {
      set_point = std::uniform_real_distribution<float>(-15, 15)(random);
    }
    command.host_us = random();
    encoded = EncodeCommand(command, kCurrentMax_A, seq, frame.data(), frame.size());
  }
  EXPECT_EQ(encoded.status, Status::kOk);
  frame.resize(encoded.size);
  return frame;
}

// Through a heap block of exactly this size, so that ASan sees a read past its end.
Status Open(const Bytes& frame) {
  const auto exact = std::make_unique<std::uint8_t[]>(frame.size());
  if (!frame.empty()) std::memcpy(exact.get(), frame.data(), frame.size());
  FrameView view;
  const Status status = OpenFrame(exact.get(), frame.size(), view);
  if (status == Status::kOk) {
    Hello hello;
    Telemetry telemetry;
    Command command;
    Decode(view, hello);
    Decode(view, telemetry);
    DecodeCommand(view, kCurrentMax_A, command);
  }
  return status;
}

TEST(WireFuzz, UpToThreeFlippedBitsAreAlwaysCaught) {
  std::mt19937_64 random(1);
  for (int i = 0; i < 20000; ++i) {
    Bytes frame = RandomFrame(random);
    ASSERT_EQ(Open(frame), Status::kOk);
    const Bytes good = frame;
    const int flips = 1 + static_cast<int>(random() % 3);
    for (int f = 0; f < flips; ++f) {
      const std::size_t bit = random() % (8 * frame.size());
      frame[bit / 8] = static_cast<std::uint8_t>(frame[bit / 8] ^ (1U << (bit % 8)));
    }
    if (frame == good) continue;
    ASSERT_NE(Open(frame), Status::kOk) << "round " << i;
  }
}

TEST(WireFuzz, RejectsTruncatedExtendedAndShiftedFrames) {
  std::mt19937_64 random(2);
  for (int i = 0; i < 5000; ++i) {
    const Bytes good = RandomFrame(random);
    const std::size_t cut = random() % good.size();
    ASSERT_NE(Open(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(cut))), Status::kOk);
    Bytes longer = good;
    longer.push_back(static_cast<std::uint8_t>(random()));
    ASSERT_NE(Open(longer), Status::kOk);
    Bytes shifted(good.begin() + 1, good.end());
    shifted.push_back(good.front());
    ASSERT_NE(Open(shifted), Status::kOk);
  }
}

TEST(WireFuzz, RejectsRandomBytes) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 50000; ++i) {
    Bytes frame(random() % 600);
    for (std::uint8_t& byte : frame) byte = static_cast<std::uint8_t>(random());
    if (frame.size() > 8 && i % 2 == 0) {  // half of them pass the cheap checks
      frame[0] = 'O';
      frame[1] = 'M';
      frame[2] = kVersion;
      const auto payload = static_cast<std::uint16_t>(frame.size() - kHeaderSize - kTrailerSize);
      frame[6] = static_cast<std::uint8_t>(payload);
      frame[7] = static_cast<std::uint8_t>(payload >> 8);
    }
    ASSERT_NE(Open(frame), Status::kOk);
  }
}

// A decoder must survive any payload behind a valid CRC, and never hand out a bad set-point.
TEST(WireFuzz, RandomCommandsNeverYieldBadSetPoints) {
  std::mt19937_64 random(4);
  int accepted = 0;
  for (int i = 0; i < 50000; ++i) {
    Bytes frame(kFrameSizeMax);
    const std::size_t size = random() % 120;
    for (std::size_t b = 0; b < size; ++b) frame[kHeaderSize + b] = static_cast<std::uint8_t>(random());
    if (i % 2 == 0) {
      frame[kHeaderSize] = 1;  // mode and time to live in range: the set-points decide
      frame[kHeaderSize + 2] = 20;
      frame[kHeaderSize + 3] = 0;
    }
    Header header;
    header.type = MessageType::kCommand;
    const Encoded encoded = SealFrame(header, size, frame.data(), frame.size());
    frame.resize(encoded.size);
    FrameView view;
    ASSERT_EQ(OpenFrame(frame.data(), frame.size(), view), Status::kOk);
    Command command;
    if (DecodeCommand(view, kCurrentMax_A, command) != Status::kOk) continue;
    ++accepted;
    for (const float set_point : command.set_point_A) ASSERT_TRUE(set_point >= -15 && set_point <= 15);
  }
  EXPECT_GT(accepted, 0);
}

// Every decoder over one valid envelope; how many took it. Through a heap block of exactly this size.
int DecodeAsAll(const Bytes& frame) {
  const auto exact = std::make_unique<std::uint8_t[]>(frame.size());
  std::memcpy(exact.get(), frame.data(), frame.size());
  FrameView view;
  if (OpenFrame(exact.get(), frame.size(), view) != Status::kOk) return -1;
  Hello hello;
  Telemetry telemetry;
  Command command;
  Config config;
  Arm arm;
  Estop estop;
  FaultEvent event;
  Log log;
  const Status statuses[] = {Decode(view, hello),  Decode(view, telemetry), DecodeCommand(view, kCurrentMax_A, command),
                             Decode(view, config), Decode(view, arm),       Decode(view, estop),
                             Decode(view, event),  Decode(view, log)};
  return static_cast<int>(std::count(std::begin(statuses), std::end(statuses), Status::kOk));
}

// A million payloads of noise (scripts/fuzz runs more, by OMNI_FUZZ), each behind a valid envelope of a random
// type: at most the one decoder of that type takes it. Half of them begin as a valid message does, so that the checks
// behind the first are reached.
TEST(WireFuzz, RandomPayloadsAreDecodedByAtMostOneType) {
  std::mt19937_64 random(5);
  std::int64_t accepted[9] = {};
  const char* asked = std::getenv("OMNI_FUZZ");
  const std::int64_t count = asked != nullptr ? std::atoll(asked) : 1'000'000;
  for (std::int64_t i = 0; i < count; ++i) {
    const std::uint64_t dice = random();
    Bytes frame(kHeaderSize + dice % 130 + kTrailerSize);
    for (std::size_t b = kHeaderSize; b < frame.size(); b += 8) {
      const std::uint64_t noise = random();
      std::memcpy(&frame[b], &noise, std::min<std::size_t>(8, frame.size() - b));
    }
    if ((dice >> 8) % 2 == 0 && frame.size() > kHeaderSize + kTrailerSize) {
      frame[kHeaderSize] = static_cast<std::uint8_t>((dice >> 16) % 6);
    }
    Header header;
    header.type = static_cast<MessageType>(1 + (dice >> 32) % 8);
    ASSERT_EQ(SealFrame(header, frame.size() - kHeaderSize - kTrailerSize, frame.data(), frame.size()).status,
              Status::kOk);
    const int taken = DecodeAsAll(frame);
    ASSERT_TRUE(taken == 0 || taken == 1) << "round " << i;
    accepted[static_cast<std::size_t>(header.type)] += taken;
  }
  for (const MessageType type :
       {MessageType::kConfig, MessageType::kArm, MessageType::kEstop, MessageType::kFault, MessageType::kLog}) {
    EXPECT_GT(accepted[static_cast<std::size_t>(type)], 0) << static_cast<int>(type) << " was never reached";
  }
  RecordProperty("frames", std::to_string(count));
  RecordProperty("decoded", std::to_string(std::accumulate(std::begin(accepted), std::end(accepted), std::int64_t{0})));
}

}  // namespace test_wire_fuzz
}  // namespace omni::wire
