// Frames of firmware/wire: golden bytes, round trips, and a status for every error.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "firmware/wire/frame.h"
#include "firmware/wire/messages.h"
#include "tests/support/hex.h"

namespace omni::wire {
namespace test_wire_frames {

constexpr float kCurrentMax_A = 15;

using Bytes = std::vector<std::uint8_t>;

Command SampleCommand() {
  Command command;
  command.mode = Mode::kCurrent;
  command.time_to_live_ms = 20;
  command.set_point_A[0] = 1.5F;
  command.set_point_A[1] = -2.0F;
  command.set_point_A[2] = 0.25F;
  command.host_us = 0x0102030405060708U;
  command.echo_device_us = 77;
  return command;
}

Telemetry SampleTelemetry() {
  Telemetry telemetry;
  for (int i = 0; i < kSensors; ++i) {
    for (int axis = 0; axis < 3; ++axis) telemetry.field[i][axis] = static_cast<std::int16_t>(1000 * i - 3000 + axis);
    telemetry.age[i] = static_cast<std::uint8_t>(i);
  }
  telemetry.fresh_mask = 0xFD;
  telemetry.state = State::kArmed;
  telemetry.saturated_mask = 0x800001;
  for (int step = 0; step < kStepsPerTick; ++step) telemetry.current[step][1] = static_cast<std::int16_t>(-1600 - step);
  telemetry.temperature[2] = 4550;
  telemetry.supply = 14400;
  telemetry.faults = kFaultHostSilent | kFaultOverTemperature;
  telemetry.ack_seq = 65535;
  telemetry.ack_host_us = 123456789;
  telemetry.rejected = 3;
  telemetry.missed_ticks = 4;
  for (int k = 0; k < kCoils; ++k) {
    telemetry.voltage[k] = static_cast<std::uint16_t>(100 * (k + 1));
    telemetry.resistance[k] = static_cast<std::uint16_t>(6430 + 325 * k + (k == 1 ? 5 : 0));
  }
  telemetry.duty[0] = -kDutyFull;
  telemetry.duty[2] = 1000;
  telemetry.board_temperature = 2512;
  telemetry.fan_rpm = 3000;
  telemetry.ack_rx_device_us = 0xFFFFFFFEU;
  telemetry.tick_lead = 777;
  return telemetry;
}

Bytes EncodedCommand() {
  Bytes frame(kFrameSizeMax);
  const Encoded encoded = EncodeCommand(SampleCommand(), kCurrentMax_A, 513, frame.data(), frame.size());
  EXPECT_EQ(encoded.status, Status::kOk);
  frame.resize(encoded.size);
  return frame;
}

Bytes EncodedTelemetry() {
  Bytes frame(kFrameSizeMax);
  const Encoded encoded = Encode(SampleTelemetry(), 7, 1'000'000, frame.data(), frame.size());
  EXPECT_EQ(encoded.status, Status::kOk);
  frame.resize(encoded.size);
  return frame;
}

// Writes a valid CRC for the bytes in the frame.
void Reseal(Bytes& frame) {
  const std::size_t body = frame.size() - kTrailerSize;
  const std::uint32_t crc = Crc32c(frame.data(), body);
  for (std::size_t i = 0; i < 4; ++i) frame[body + i] = static_cast<std::uint8_t>(crc >> (8 * i));
}

Status Open(const Bytes& frame) {
  FrameView view;
  return OpenFrame(frame.data(), frame.size(), view);
}

Status OpenAsCommand(const Bytes& frame) {
  FrameView view;
  Command command;
  const Status status = OpenFrame(frame.data(), frame.size(), view);
  return status == Status::kOk ? DecodeCommand(view, kCurrentMax_A, command) : status;
}

TEST(Crc32c, MatchesKnownVectors) {
  // RFC 3720, B.4, and the usual check value.
  const std::string digits = "123456789";
  EXPECT_EQ(Crc32c(reinterpret_cast<const std::uint8_t*>(digits.data()), digits.size()), 0xE3069283U);
  EXPECT_EQ(Crc32c(Bytes(32, 0x00).data(), 32), 0x8A9136AAU);
  EXPECT_EQ(Crc32c(Bytes(32, 0xFF).data(), 32), 0x62A8AB43U);
}

// Golden bytes were made by an independent program (Python struct and a bitwise CRC).
TEST(WireGolden, CommandBytesNeverChange) {
  EXPECT_EQ(support::Hex(EncodedCommand()),
            "4f4d0103010220000000000000000000010014000000c03f000000c00000803e08070605"
            "040302014d00000000000000bc950936");
}

TEST(WireGolden, TelemetryBytesNeverChange) {
  EXPECT_EQ(support::Hex(EncodedTelemetry()),
            "4f4d010207008c0040420f000000000048f449f44af430f831f832f818fc19fc1afc0000"
            "01000200e803e903ea03d007d107d207b80bb90bba0ba00fa10fa20ffd03000102030405"
            "0607010080000000c0f900000000bff900000000bef900000000bdf9000000000000c611"
            "403806000000ffff15cd5b0700000000030004006400c8002c011e19681aa81b01800000"
            "e803d009b80bfeffffff0903f07b2df4");
}

TEST(WireRoundTrip, Command) {
  const Bytes frame = EncodedCommand();
  EXPECT_EQ(frame.size(), FrameSize<Command>());
  FrameView view;
  ASSERT_EQ(OpenFrame(frame.data(), frame.size(), view), Status::kOk);
  EXPECT_EQ(view.header.seq, 513);
  Command command;
  ASSERT_EQ(DecodeCommand(view, kCurrentMax_A, command), Status::kOk);
  EXPECT_EQ(command.mode, Mode::kCurrent);
  EXPECT_EQ(command.set_point_A[1], -2.0F);
  EXPECT_EQ(command.host_us, SampleCommand().host_us);
  EXPECT_EQ(command.echo_device_us, 77U);
}

TEST(WireRoundTrip, Telemetry) {
  const Bytes frame = EncodedTelemetry();
  EXPECT_EQ(frame.size(), FrameSize<Telemetry>());
  FrameView view;
  ASSERT_EQ(OpenFrame(frame.data(), frame.size(), view), Status::kOk);
  EXPECT_EQ(view.header.t_device_us, 1'000'000U);
  Telemetry telemetry;
  ASSERT_EQ(Decode(view, telemetry), Status::kOk);
  const Telemetry sent = SampleTelemetry();
  EXPECT_EQ(std::memcmp(telemetry.field, sent.field, sizeof sent.field), 0);
  EXPECT_EQ(std::memcmp(telemetry.age, sent.age, sizeof sent.age), 0);
  EXPECT_EQ(telemetry.fresh_mask, sent.fresh_mask);
  EXPECT_EQ(telemetry.saturated_mask, sent.saturated_mask);
  EXPECT_EQ(telemetry.current[2][1], sent.current[2][1]);
  EXPECT_EQ(telemetry.tick_lead, 777);
  EXPECT_EQ(telemetry.temperature[2], sent.temperature[2]);
  EXPECT_EQ(telemetry.supply, sent.supply);
  EXPECT_EQ(telemetry.faults, sent.faults);
  EXPECT_EQ(telemetry.state, State::kArmed);
  EXPECT_EQ(telemetry.ack_seq, sent.ack_seq);
  EXPECT_EQ(telemetry.ack_host_us, sent.ack_host_us);
  EXPECT_EQ(telemetry.rejected, 3);
  EXPECT_EQ(telemetry.missed_ticks, 4);
}

TEST(WireRoundTrip, Hello) {
  Hello hello;
  hello.firmware_version = 258;
  hello.capabilities = kDeviceClockIsHostMonotonic | kSimulation;
  std::memcpy(hello.serial, "0123456789abcdef", 16);
  hello.field_lsb_T = 5.8e-8F;
  hello.field_full_scale = 27376;
  hello.current_max_A = 15;
  hello.calibration_hash = 0xFEDCBA9876543210U;
  Bytes frame(kFrameSizeMax);
  const Encoded encoded = Encode(hello, 1, 2, frame.data(), frame.size());
  ASSERT_EQ(encoded.status, Status::kOk);
  EXPECT_EQ(encoded.size, kHeaderSize + PayloadSize<Hello>() + kTrailerSize);
  FrameView view;
  ASSERT_EQ(OpenFrame(frame.data(), encoded.size, view), Status::kOk);
  Hello back;
  ASSERT_EQ(Decode(view, back), Status::kOk);
  EXPECT_EQ(back.firmware_version, 258);
  EXPECT_EQ(back.capabilities, hello.capabilities);
  EXPECT_EQ(std::memcmp(back.serial, hello.serial, 16), 0);
  EXPECT_EQ(back.field_lsb_T, hello.field_lsb_T);
  EXPECT_EQ(back.field_full_scale, 27376);
  EXPECT_EQ(back.calibration_hash, hello.calibration_hash);
  hello.field_lsb_T = 0;
  Encode(hello, 1, 2, frame.data(), frame.size());
  ASSERT_EQ(OpenFrame(frame.data(), encoded.size, view), Status::kOk);
  EXPECT_EQ(Decode(view, back), Status::kOutOfRange);
}

TEST(WireBadInput, ReportsEachEnvelopeErrorByStatus) {
  const Bytes good = EncodedCommand();
  EXPECT_EQ(Open(Bytes(good.begin(), good.begin() + 19)), Status::kTooShort);
  EXPECT_EQ(Open({}), Status::kTooShort);
  EXPECT_EQ(Open(Bytes(512, 0)), Status::kTooLong);
  Bytes bad = good;
  bad[0] = 'X';
  Reseal(bad);
  EXPECT_EQ(Open(bad), Status::kBadMagic);
  bad = good;
  bad[2] = 2;
  Reseal(bad);
  EXPECT_EQ(Open(bad), Status::kBadVersion);
  bad = good;
  bad[6] = 33;
  Reseal(bad);
  EXPECT_EQ(Open(bad), Status::kBadLength);
  bad = good;
  bad[20] ^= 1;
  EXPECT_EQ(Open(bad), Status::kBadCrc);
  bad = good;
  bad[3] = 200;
  Reseal(bad);
  EXPECT_EQ(Open(bad), Status::kUnknownType);
  EXPECT_EQ(OpenAsCommand(EncodedTelemetry()), Status::kWrongType);
}

TEST(WireBadInput, RejectsTruncatedPayloadWithValidCrc) {
  Bytes bad = EncodedCommand();
  bad.resize(bad.size() - 1);
  bad[6] = 31;
  Reseal(bad);
  EXPECT_EQ(OpenAsCommand(bad), Status::kShortPayload);
}

TEST(WireBadInput, LongerPayloadOfANewerPeerIsAccepted) {
  Bytes longer = EncodedCommand();
  longer.insert(longer.end() - 4, {1, 2, 3});
  longer[6] = 35;
  Reseal(longer);
  EXPECT_EQ(OpenAsCommand(longer), Status::kOk);
}

TEST(WireBadInput, EncoderAndDecoderRejectBadSetPoints) {
  Bytes frame(kFrameSizeMax);
  const auto status = [&](const Command& command) {
    return EncodeCommand(command, kCurrentMax_A, 0, frame.data(), frame.size()).status;
  };
  for (const float bad : {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity()}) {
    Command command = SampleCommand();
    command.set_point_A[2] = bad;
    EXPECT_EQ(status(command), Status::kNotFinite);
    Bytes raw = EncodedCommand();
    std::memcpy(&raw[kHeaderSize + 12], &bad, 4);
    Reseal(raw);
    EXPECT_EQ(OpenAsCommand(raw), Status::kNotFinite);
  }
  Command command = SampleCommand();
  command.set_point_A[0] = std::nextafter(kCurrentMax_A, 100.0F);
  EXPECT_EQ(status(command), Status::kOutOfRange);
  command.set_point_A[0] = -kCurrentMax_A;
  EXPECT_EQ(status(command), Status::kOk);
  for (const std::uint16_t ttl : {std::uint16_t{0}, std::uint16_t{21}}) {
    command.time_to_live_ms = ttl;
    EXPECT_EQ(status(command), Status::kOutOfRange);
  }
  command.time_to_live_ms = 1;
  command.mode = static_cast<Mode>(9);
  EXPECT_EQ(status(command), Status::kOutOfRange);
}

TEST(WireBadInput, FailedDecodingLeavesTheMessageAlone) {
  Bytes raw = EncodedCommand();
  raw[kHeaderSize] = 99;
  Reseal(raw);
  FrameView view;
  ASSERT_EQ(OpenFrame(raw.data(), raw.size(), view), Status::kOk);
  Command command;
  command.host_us = 42;
  EXPECT_EQ(DecodeCommand(view, kCurrentMax_A, command), Status::kOutOfRange);
  EXPECT_EQ(command.host_us, 42U);
}

TEST(WireBadInput, RejectsSmallBuffersWithoutOverrun) {
  for (std::size_t capacity = 0; capacity < FrameSize<Telemetry>(); ++capacity) {
    Bytes frame(capacity + 1, 0xAA);
    const Encoded encoded = Encode(SampleTelemetry(), 0, 0, frame.data(), capacity);
    EXPECT_EQ(encoded.status, Status::kNoRoom);
    EXPECT_EQ(encoded.size, 0U);
    EXPECT_EQ(frame[capacity], 0xAA);
  }
}

TEST(WireSequence, DistanceUsesSerialNumberArithmetic) {
  EXPECT_EQ(SeqDistance(1, 2), 1);
  EXPECT_EQ(SeqDistance(65535, 0), 1);
  EXPECT_EQ(SeqDistance(0, 65535), -1);
  EXPECT_EQ(SeqDistance(5, 5), 0);
}

TEST(WireScaling, RoundsAndClips) {
  EXPECT_EQ(ToCounts<std::int16_t>(1.0, 1.25e-3), 800);
  EXPECT_EQ(ToCounts<std::int16_t>(-1.9e-3, 1.25e-3), -2);
  EXPECT_EQ(ToCounts<std::int16_t>(1e9, 1.25e-3), 32767);
  EXPECT_EQ(ToCounts<std::int16_t>(-1e9, 1.25e-3), -32768);
  EXPECT_EQ(ToCounts<std::uint8_t>(-1.0, 1.0), 0);
  EXPECT_EQ(ToCounts<std::uint8_t>(254.6, 1.0), 255);
  EXPECT_EQ(ToCounts<std::int16_t>(std::nan(""), 1.0), 0);
  EXPECT_EQ(ToCounts<std::int16_t>(std::numeric_limits<double>::infinity(), 1.0), 32767);
}

TEST(WireStatus, EveryStatusHasAName) {
  for (int i = 0; i <= static_cast<int>(Status::kNoRoom); ++i) {
    EXPECT_STRNE(StatusName(static_cast<Status>(i)), "unknown status");
  }
}

}  // namespace test_wire_frames
}  // namespace omni::wire
