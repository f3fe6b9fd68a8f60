// HELLO, CONFIG, ARM, ESTOP, FAULT and LOG: golden bytes, round trips, and what decoding rejects. Golden bytes were
// made by an independent program (Python struct and a bitwise CRC). COMMAND and TELEMETRY: frames.cc.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "firmware/wire/frame.h"
#include "firmware/wire/messages.h"
#include "tests/support/hex.h"

namespace omni::wire {
namespace test_wire_messages {

using Bytes = std::vector<std::uint8_t>;

Hello SampleHello() {
  Hello hello;
  hello.firmware_version = 258;
  hello.capabilities = kDeviceClockIsHostMonotonic | kSimulation;
  std::memcpy(hello.serial, "0123456789abcdef", sizeof hello.serial);
  hello.field_lsb_T = 5.8e-8F;
  hello.field_full_scale = 27376;
  hello.current_max_A = 15;
  hello.calibration_hash = 0xFEDCBA9876543210U;
  return hello;
}

Config SampleConfig() {
  Config config;
  config.op = ConfigOp::kSet;
  config.id = static_cast<std::uint16_t>(ConfigId::kResistance20_ohm) + 2;
  config.value = 0.697F;
  return config;
}

Arm SampleArm() {
  Arm arm;
  arm.step = ArmStep::kChallenge;
  arm.nonce = 0xDEADBEEFU;
  arm.faults = kFaultOverTemperature | kFaultEmergencyStop;
  return arm;
}

Estop SampleEstop() {
  Estop estop;
  estop.reason = 7;
  return estop;
}

FaultEvent SampleFault() {
  FaultEvent event;
  event.fault = kFaultOverCurrent;
  event.faults = kFaultOverCurrent | kFaultCoilShort;
  event.state = State::kArmed;
  event.part = 2;
  event.after_reset = 1;
  event.value = 15.75F;
  event.t_us = 4'999'750;
  return event;
}

Log SampleLog() {
  constexpr char kText[] = "fan: 0 turns/min?";
  Log log;
  log.level = LogLevel::kWarning;
  log.size = sizeof kText - 1;
  std::memcpy(log.text, kText, sizeof kText - 1);
  return log;
}

template <class Message>
Bytes Framed(const Message& message, std::uint16_t seq, std::uint64_t t_device_us) {
  Bytes frame(kFrameSizeMax);
  const Encoded encoded = Encode(message, seq, t_device_us, frame.data(), frame.size());
  EXPECT_EQ(encoded.status, Status::kOk);
  EXPECT_EQ(encoded.size, FrameSize<Message>());
  frame.resize(encoded.size);
  return frame;
}

template <class Message>
Status Opened(const Bytes& frame, Message& message) {
  FrameView view;
  const Status status = OpenFrame(frame.data(), frame.size(), view);
  return status == Status::kOk ? Decode(view, message) : status;
}

TEST(WireGolden, HelloBytesNeverChange) {
  EXPECT_EQ(support::Hex(Framed(SampleHello(), 1, 2)),
            "4f4d010101002c0002000000000000000101020103000000303132333435363738396162"
            "63646566ad1b7933f06a0000000070411032547698badcfe1232243c");
}

TEST(WireGolden, ConfigBytesNeverChange) {
  EXPECT_EQ(support::Hex(Framed(SampleConfig(), 65535, 0)), "4f4d0104ffff0800000000000000000002001200986e323f7ebbdd9a");
}

TEST(WireGolden, ArmBytesNeverChange) {
  EXPECT_EQ(support::Hex(Framed(SampleArm(), 9, 123'456'789'012)),
            "4f4d010509000c00141a99be1c00000002010000efbeadde04000100ab65c034");
}

TEST(WireGolden, EstopBytesNeverChange) {
  EXPECT_EQ(support::Hex(Framed(SampleEstop(), 0, 0)), "4f4d010600000100000000000000000007183c8b36");
}

TEST(WireGolden, FaultBytesNeverChange) {
  EXPECT_EQ(support::Hex(Framed(SampleFault(), 300, 5'000'000)),
            "4f4d01072c011800404b4c000000000008000000080200000302010000007c41464a4c0000000000cc1ce600");
}

TEST(WireGolden, LogBytesNeverChange) {
  const std::string padding(2 * (kLogTextMax - 17), '0');
  EXPECT_EQ(support::Hex(Framed(SampleLog(), 2, 42)),
            "4f4d010802007a002a00000000000000021166616e3a2030207475726e732f6d696e3f" + padding + "6396790a");
}

TEST(WireRoundTrip, ConfigArmAndEstop) {
  Config config;
  ASSERT_EQ(Opened(Framed(SampleConfig(), 1, 0), config), Status::kOk);
  EXPECT_EQ(config.op, ConfigOp::kSet);
  EXPECT_EQ(config.id, 0x12);
  EXPECT_EQ(config.value, 0.697F);
  Arm arm;
  ASSERT_EQ(Opened(Framed(SampleArm(), 1, 0), arm), Status::kOk);
  EXPECT_EQ(arm.step, ArmStep::kChallenge);
  EXPECT_EQ(arm.version, kVersion);
  EXPECT_EQ(arm.nonce, 0xDEADBEEFU);
  EXPECT_EQ(arm.faults, kFaultOverTemperature | kFaultEmergencyStop);
  Estop estop;
  ASSERT_EQ(Opened(Framed(SampleEstop(), 1, 0), estop), Status::kOk);
  EXPECT_EQ(estop.reason, 7);
}

TEST(WireRoundTrip, FaultAndLog) {
  FaultEvent event;
  ASSERT_EQ(Opened(Framed(SampleFault(), 1, 0), event), Status::kOk);
  EXPECT_EQ(event.fault, kFaultOverCurrent);
  EXPECT_EQ(event.faults, kFaultOverCurrent | kFaultCoilShort);
  EXPECT_EQ(event.state, State::kArmed);
  EXPECT_EQ(event.part, 2);
  EXPECT_EQ(event.after_reset, 1);
  EXPECT_EQ(event.value, 15.75F);
  EXPECT_EQ(event.t_us, 4'999'750U);
  Log log;
  ASSERT_EQ(Opened(Framed(SampleLog(), 1, 0), log), Status::kOk);
  EXPECT_EQ(log.level, LogLevel::kWarning);
  EXPECT_EQ(std::string(log.text, log.size), "fan: 0 turns/min?");
}

// The status of decoding a message with one value changed and a valid CRC.
template <class Message, class Change>
Status DecodedWith(Message message, Change change) {
  change(message);
  Message back;
  return Opened(Framed(message, 1, 0), back);
}

TEST(WireBadInput, RejectsValuesOutOfRange) {
  for (const int op : {0, 5, 255}) {
    EXPECT_EQ(DecodedWith(SampleConfig(), [&](Config& c) { c.op = static_cast<ConfigOp>(op); }), Status::kOutOfRange);
  }
  for (const int step : {0, 6, 255}) {
    EXPECT_EQ(DecodedWith(SampleArm(), [&](Arm& a) { a.step = static_cast<ArmStep>(step); }), Status::kOutOfRange);
  }
  for (const int state : {5, 255}) {
    EXPECT_EQ(DecodedWith(SampleFault(), [&](FaultEvent& e) { e.state = static_cast<State>(state); }),
              Status::kOutOfRange);
    EXPECT_EQ(DecodedWith(Telemetry{}, [&](Telemetry& t) { t.state = static_cast<State>(state); }),
              Status::kOutOfRange);
  }
  EXPECT_EQ(DecodedWith(Telemetry{}, [](Telemetry& t) { t.saturated_mask = 1U << 24; }), Status::kOutOfRange);
  EXPECT_EQ(DecodedWith(SampleLog(), [](Log& l) { l.level = static_cast<LogLevel>(4); }), Status::kOutOfRange);
  EXPECT_EQ(DecodedWith(SampleLog(), [](Log& l) { l.size = kLogTextMax + 1; }), Status::kOutOfRange);
  EXPECT_EQ(DecodedWith(SampleHello(), [](Hello& h) { h.version_min = 2; }), Status::kOutOfRange);
  EXPECT_EQ(DecodedWith(SampleHello(), [](Hello& h) { h.field_full_scale = 0; }), Status::kOutOfRange);
  EXPECT_EQ(DecodedWith(SampleHello(), [](Hello& h) { h.field_full_scale = 0x8000; }), Status::kOutOfRange);
  EXPECT_EQ(DecodedWith(SampleHello(), [](Hello& h) { h.field_full_scale = 0x7FFF; }), Status::kOk);
  EXPECT_EQ(DecodedWith(SampleHello(), [](Hello& h) { h.current_max_A = -15; }), Status::kOutOfRange);
}

TEST(WireBadInput, RejectsNonFiniteNumbers) {
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity()}) {
    EXPECT_EQ(DecodedWith(SampleConfig(), [&](Config& c) { c.value = bad; }), Status::kNotFinite);
    EXPECT_EQ(DecodedWith(SampleFault(), [&](FaultEvent& e) { e.value = bad; }), Status::kNotFinite);
    EXPECT_EQ(DecodedWith(SampleHello(), [&](Hello& h) { h.field_lsb_T = bad; }), Status::kNotFinite);
  }
}

void PutCrc(Bytes& frame) {
  const std::size_t body = frame.size() - kTrailerSize;
  const std::uint32_t crc = Crc32c(frame.data(), body);
  for (std::size_t i = 0; i < kTrailerSize; ++i) frame[body + i] = static_cast<std::uint8_t>(crc >> (8 * i));
}

// The frame with a payload of another length and a valid CRC.
Bytes Resized(Bytes frame, int by) {
  frame.resize(frame.size() + static_cast<std::size_t>(by), 0xEE);
  const std::size_t payload = frame.size() - kHeaderSize - kTrailerSize;
  frame[6] = static_cast<std::uint8_t>(payload);
  frame[7] = static_cast<std::uint8_t>(payload >> 8);
  PutCrc(frame);
  return frame;
}

template <class Message>
void ExpectLengthRules(const Message& message) {
  const Bytes frame = Framed(message, 3, 4);
  Message back;
  EXPECT_EQ(Opened(Resized(frame, -1), back), Status::kShortPayload);
  EXPECT_EQ(Opened(Resized(frame, 5), back), Status::kOk) << "a newer peer appends fields";
  Bytes other = frame;
  other[2] = kVersion + 1;
  PutCrc(other);
  EXPECT_EQ(Opened(other, back), Message::kType == MessageType::kHello ? Status::kOk : Status::kBadVersion);
}

TEST(WireBadInput, ChecksLengthAndVersionOfEveryMessage) {
  ExpectLengthRules(SampleHello());
  ExpectLengthRules(Telemetry{});
  ExpectLengthRules(Command{});
  ExpectLengthRules(SampleConfig());
  ExpectLengthRules(SampleArm());
  ExpectLengthRules(SampleEstop());
  ExpectLengthRules(SampleFault());
  ExpectLengthRules(SampleLog());
}

TEST(WireBadInput, RejectsMessagesOfAnotherType) {
  Config config;
  Arm arm;
  Estop estop;
  FaultEvent event;
  Log log;
  EXPECT_EQ(Opened(Framed(SampleLog(), 1, 0), config), Status::kWrongType);
  EXPECT_EQ(Opened(Framed(SampleLog(), 1, 0), arm), Status::kWrongType);
  EXPECT_EQ(Opened(Framed(SampleLog(), 1, 0), estop), Status::kWrongType);
  EXPECT_EQ(Opened(Framed(SampleLog(), 1, 0), event), Status::kWrongType);
  EXPECT_EQ(Opened(Framed(SampleEstop(), 1, 0), log), Status::kWrongType);
}

TEST(WireBadInput, EncodeNeverWritesBeyondASmallBuffer) {
  const Bytes whole = Framed(SampleFault(), 1, 0);
  for (std::size_t capacity = 0; capacity < whole.size(); ++capacity) {
    Bytes frame(capacity + 1, 0xAA);
    EXPECT_EQ(Encode(SampleFault(), 1, 0, frame.data(), capacity).status, Status::kNoRoom);
    EXPECT_EQ(frame[capacity], 0xAA);
  }
}

}  // namespace test_wire_messages
}  // namespace omni::wire
