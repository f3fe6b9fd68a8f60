// Invalid input over the link: counted, answered where there is an answer, without any effect.
#include <gtest/gtest.h>

#include <limits>

#include "firmware/wire/frame.h"
#include "tests/support/chips/firmware_bench.h"

namespace omni::firmware {
namespace test_firmware_link {

using wire::ConfigId;
using wire::ConfigOp;
using wire::State;

void Reseal(Bytes& frame) {
  const std::size_t body = frame.size() - wire::kTrailerSize;
  const std::uint32_t crc = wire::Crc32c(frame.data(), body);
  for (std::size_t i = 0; i < 4; ++i) frame[body + i] = static_cast<std::uint8_t>(crc >> (8 * i));
}

// Armed at 2 A in all coils by a host that commands 1 kHz; bad frames ask for 14 A.
class FirmwareLink : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(bench_.RunToArmed());
    bench_.SetAll(2);
    bench_.RunMs(50);
    rejected_ = bench_.telemetry.rejected;
    bench_.each_step = [this] { largest_A_ = std::max(largest_A_, bench_.plant.largest_A()); };
  }

  wire::Command Bad() {
    wire::Command command = bench_.CommandNow();
    for (float& set_point_A : command.set_point_A) set_point_A = 14;
    return command;
  }

  // No frame had an effect, all were counted, and the base is unchanged.
  void ExpectRefused(int frames) {
    bench_.RunMs(10);
    EXPECT_EQ(static_cast<std::uint16_t>(bench_.telemetry.rejected - rejected_), frames);
    EXPECT_LT(largest_A_, 2.1);
    EXPECT_EQ(bench_.core.state(), State::kArmed);
    EXPECT_EQ(bench_.core.faults(), 0U);
  }

  FirmwareBench bench_;
  std::uint16_t rejected_ = 0;
  double largest_A_ = 0;
};

TEST_F(FirmwareLink, RejectsFramesWithAnyFlippedBit) {
  const Bytes good = bench_.Encoded(Bad());
  int count = 0;
  for (std::size_t i = 0; i < good.size(); ++i) {
    for (int bit = 0; bit < 8; ++bit, ++count) {
      Bytes frame = good;
      frame[i] ^= static_cast<std::uint8_t>(1U << bit);
      bench_.Receive(frame);
    }
  }
  ExpectRefused(count);
}

TEST_F(FirmwareLink, RejectsTruncatedFrames) {
  const Bytes good = bench_.Encoded(Bad());
  for (std::size_t size = 0; size < good.size(); ++size)
    bench_.Receive(Bytes(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size)));
  ExpectRefused(static_cast<int>(good.size()));
}

TEST_F(FirmwareLink, RejectsOversizedFrames) {
  bench_.Receive(Bytes(2000, 0x4F));
  ExpectRefused(1);
}

TEST_F(FirmwareLink, RejectsReplayedAndDuplicatedCommands) {
  const Bytes frame = bench_.Encoded(bench_.CommandNow());
  --bench_.seq;
  bench_.SetAll(0.5F);
  const Bytes other = bench_.Encoded(bench_.CommandNow());  // the same order, other contents: still refused
  ASSERT_NE(other, frame);
  bench_.Receive(frame);
  bench_.RunMs(5);
  bench_.Receive(frame);
  bench_.Receive(other);
  ExpectRefused(2);
}

TEST_F(FirmwareLink, RejectsReorderedCommands) {
  const Bytes late = bench_.Encoded(Bad());
  bench_.SendCommand();
  bench_.Receive(late);
  ExpectRefused(1);
}

// A frame recorded 40 s ago looks newer by its number alone.
TEST_F(FirmwareLink, RejectsOldCommandsAfterSequenceWrap) {
  wire::Command old = Bad();
  old.host_us -= 20'000;
  bench_.seq = static_cast<std::uint16_t>(bench_.seq + 1000);
  bench_.Send(old);
  bench_.seq = static_cast<std::uint16_t>(bench_.seq - 1001);
  ExpectRefused(1);
}

TEST(FirmwareLinkOrder, AcceptsCommandsAcrossSequenceWrap) {
  FirmwareBench bench;
  bench.seq = 0xFE00;
  ASSERT_TRUE(bench.RunToArmed());
  bench.SetAll(1);
  bench.RunMs(1000);
  EXPECT_LT(bench.seq, 0x1000);
  EXPECT_EQ(bench.telemetry.rejected, 0);
  EXPECT_EQ(bench.telemetry.ack_seq, bench.seq - 1);
  EXPECT_EQ(bench.core.state(), State::kArmed);
}

TEST_F(FirmwareLink, RejectsNonFiniteAndTooLargeSetPoints) {
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                            -std::numeric_limits<float>::infinity(), 15.01F, -1e30F};
  for (const float bad : kBad) {
    wire::Command command = Bad();
    Bytes frame = bench_.Encoded(command);  // Encode itself would refuse the value
    std::uint32_t bits = 0;
    std::memcpy(&bits, &bad, sizeof bits);
    for (std::size_t i = 0; i < 4; ++i) frame[wire::kHeaderSize + 4 + i] = static_cast<std::uint8_t>(bits >> (8 * i));
    Reseal(frame);
    bench_.Receive(frame);
  }
  ExpectRefused(5);
}

TEST_F(FirmwareLink, RejectsFieldsOutOfRange) {
  wire::Command command = Bad();
  command.time_to_live_ms = 0;
  bench_.Send(command);
  command.time_to_live_ms = 21;
  bench_.Send(command);
  command = Bad();
  command.mode = static_cast<wire::Mode>(2);
  bench_.Send(command);
  ExpectRefused(3);
}

TEST_F(FirmwareLink, RejectsOtherVersionsAndTypes) {
  Bytes frame = bench_.Encoded(Bad());
  frame[2] = wire::kVersion + 1;
  Reseal(frame);
  bench_.Receive(frame);
  frame = bench_.Encoded(Bad());
  frame[3] = 99;
  Reseal(frame);
  bench_.Receive(frame);
  bench_.Send(wire::Telemetry{});  // the base's own
  bench_.Send(wire::Log{});
  bench_.Send(wire::FaultEvent{});
  ExpectRefused(5);
}

TEST_F(FirmwareLink, HelloFloodDropsAnswersNotControl) {
  for (int i = 0; i < 1000; ++i) bench_.Send(wire::Hello{});
  bench_.Fetch();
  ExpectRefused(0);
  EXPECT_LE(bench_.answers.size(), 8U + 10U);
}

TEST_F(FirmwareLink, ModeOffStaysArmedWithoutCurrent) {
  bench_.host_speaks = false;
  for (int i = 0; i < 30; ++i) {
    wire::Command command = Bad();
    command.mode = wire::Mode::kOff;
    bench_.Send(command);
    bench_.RunMs(1);
  }
  EXPECT_LT(bench_.plant.largest_A(), 0.01);
  EXPECT_EQ(bench_.core.state(), State::kArmed);
}

TEST(FirmwareHello, ReportsIdentityAndCapabilities) {
  FirmwareBench bench;
  Bytes ask(wire::kFrameSizeMax);
  wire::Header header;
  ask.resize(wire::SealFrame(header, 0, ask.data(), ask.size()).size);
  bench.Receive(ask);
  bench.Step();
  wire::Hello hello;
  ASSERT_TRUE(bench.Take(hello));
  EXPECT_EQ(std::string(hello.serial), "omni");
  EXPECT_EQ(hello.current_max_A, 15);
  EXPECT_EQ(hello.capabilities & wire::kArming, wire::kArming);
}

// A flood of requests is answered at most 8 times, and costs no telemetry.
TEST(FirmwareHello, QueuedAnswersAreBounded) {
  FirmwareBench bench;
  Bytes ask(wire::kFrameSizeMax);
  wire::Header header;
  ask.resize(wire::SealFrame(header, 0, ask.data(), ask.size()).size);
  for (int i = 0; i < 100; ++i) bench.Receive(ask);
  bench.RunMs(1);
  EXPECT_EQ(bench.answers.size(), 8U);
  EXPECT_EQ(bench.telemetry_count, 1);
}

class FirmwareConfig : public testing::Test {
 protected:
  void SetUp() override { ASSERT_TRUE(bench_.RunUntil(State::kIdle, 1000)); }

  wire::Config Ask(ConfigOp op, std::uint16_t id, float value = 0) {
    wire::Config config;
    config.op = op;
    config.id = id;
    config.value = value;
    bench_.Send(config);
    bench_.Fetch();
    config.op = static_cast<ConfigOp>(0);
    bench_.Take(config);
    return config;
  }
  static std::uint16_t Id(ConfigId id, int coil = 0) { return static_cast<std::uint16_t>(static_cast<int>(id) + coil); }

  FirmwareBench bench_;
};

TEST_F(FirmwareConfig, SetsValuesOnlyWithinTheBuiltLimits) {
  EXPECT_EQ(Ask(ConfigOp::kGet, Id(ConfigId::kPowerMax_W)).value, 600);
  wire::Config answer = Ask(ConfigOp::kSet, Id(ConfigId::kPowerMax_W), 100);
  EXPECT_EQ(answer.op, ConfigOp::kValue);
  EXPECT_EQ(answer.value, 100);
  answer = Ask(ConfigOp::kSet, Id(ConfigId::kPowerMax_W), 601);
  EXPECT_EQ(answer.op, ConfigOp::kRefused);
  EXPECT_EQ(answer.value, 100);  // still in force
  EXPECT_EQ(Ask(ConfigOp::kSet, Id(ConfigId::kPowerMax_W), -1).op, ConfigOp::kRefused);
  answer = Ask(ConfigOp::kSet, Id(ConfigId::kResistance20_ohm, 2), 0.72F);
  EXPECT_EQ(answer.op, ConfigOp::kValue);
  EXPECT_EQ(bench_.core.settings().coils[2].resistance_20C_ohm, 0.72F);
  EXPECT_EQ(Ask(ConfigOp::kSet, Id(ConfigId::kResistance20_ohm, 2), 1.5F).op, ConfigOp::kRefused);
  EXPECT_EQ(Ask(ConfigOp::kSet, Id(ConfigId::kTemperatureDerate_C), 69).op, ConfigOp::kRefused);  // too near the limit
  EXPECT_EQ(Ask(ConfigOp::kGet, 999).op, ConfigOp::kRefused);
}

TEST_F(FirmwareConfig, SetsInIdleOnly) {
  EXPECT_EQ(bench_.Arm().step, wire::ArmStep::kArmed);
  EXPECT_EQ(Ask(ConfigOp::kSet, Id(ConfigId::kPowerMax_W), 100).op, ConfigOp::kRefused);
  EXPECT_EQ(Ask(ConfigOp::kGet, Id(ConfigId::kPowerMax_W)).value, 600);
}

TEST_F(FirmwareConfig, IgnoresReplayedSet) {
  wire::Config config;
  config.op = ConfigOp::kSet;
  config.id = Id(ConfigId::kPowerMax_W);
  config.value = 100;
  const Bytes old = bench_.Encoded(config);
  bench_.Receive(old);
  EXPECT_EQ(Ask(ConfigOp::kSet, Id(ConfigId::kPowerMax_W), 200).op, ConfigOp::kValue);
  bench_.Receive(old);
  EXPECT_EQ(bench_.core.settings().power_max_W, 200);
}

TEST(FirmwareLog, LogsStateChangesAtALimitedRate) {
  FirmwareBench bench;
  ASSERT_TRUE(bench.RunUntil(State::kIdle, 1000));
  wire::Log log;
  ASSERT_TRUE(bench.Take(log));
  EXPECT_EQ(std::string(log.text, log.size), "self-test -> idle");
  bench.answers.clear();
  for (int i = 0; i < 100; ++i) {  // 20 ms each
    bench.Arm();
    bench.Send(wire::Estop{});
    bench.RunMs(20);
  }
  int lines = 0;
  while (bench.Take(log)) ++lines;
  EXPECT_LE(lines, 10 + 2 * 5);
  EXPECT_GE(lines, 10);
}

}  // namespace test_firmware_link
}  // namespace omni::firmware
