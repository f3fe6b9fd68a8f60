#include "firmware/wire/messages.h"

#include <cstring>

#include "firmware/wire/bytes.h"

namespace omni::wire {
namespace {

// Exponent bits all ones: infinity or NaN [IEEE 754]. Works without a maths library and under -ffast-math.
bool IsFinite(float value) noexcept {
  std::uint32_t bits = 0;
  std::memcpy(&bits, &value, sizeof bits);
  return (bits & 0x7F800000U) != 0x7F800000U;
}

bool IsPositive(float value) noexcept { return IsFinite(value) && value > 0; }

Encoded Finish(MessageType type, std::uint16_t seq, std::uint64_t t_device_us, const ByteWriter& payload,
               std::uint8_t* frame, std::size_t capacity) noexcept {
  if (!payload.ok()) return {Status::kNoRoom, 0};
  Header header;
  header.type = type;
  header.seq = seq;
  header.t_device_us = t_device_us;
  return SealFrame(header, payload.size(), frame, capacity);
}

// Room for the payload in `frame`; 0 when not even the header fits.
std::size_t PayloadCapacity(std::size_t capacity) noexcept {
  return capacity < kHeaderSize + kTrailerSize ? 0 : capacity - kHeaderSize - kTrailerSize;
}

Status CheckView(const FrameView& view, MessageType type, std::size_t payload_size) noexcept {
  if (view.header.type != type) return Status::kWrongType;
  if (view.payload_size < payload_size) return Status::kShortPayload;
  return Status::kOk;
}

}  // namespace

Encoded EncodeHello(const Hello& hello, std::uint16_t seq, std::uint64_t t_device_us, std::uint8_t* frame,
                    std::size_t capacity) noexcept {
  if (capacity < kHeaderSize) return {Status::kNoRoom, 0};
  ByteWriter out(frame + kHeaderSize, PayloadCapacity(capacity));
  out.U8(hello.version_min);
  out.U8(hello.version_max);
  out.U16(hello.firmware_version);
  out.U32(hello.capabilities);
  for (const char c : hello.serial) out.U8(static_cast<std::uint8_t>(c));
  out.F32(hello.field_lsb_T);
  out.U16(hello.field_full_scale);
  out.U16(0);  // reserved: keeps what follows aligned
  out.F32(hello.current_max_A);
  out.U64(hello.calibration_hash);
  return Finish(MessageType::kHello, seq, t_device_us, out, frame, capacity);
}

Status DecodeHello(const FrameView& view, Hello& message) noexcept {
  const Status status = CheckView(view, MessageType::kHello, kHelloPayloadSize);
  if (status != Status::kOk) return status;
  ByteReader in(view.payload, view.payload_size);
  Hello hello;
  hello.version_min = in.U8();
  hello.version_max = in.U8();
  hello.firmware_version = in.U16();
  hello.capabilities = in.U32();
  for (char& c : hello.serial) c = static_cast<char>(in.U8());
  hello.field_lsb_T = in.F32();
  hello.field_full_scale = in.U16();
  in.U16();
  hello.current_max_A = in.F32();
  hello.calibration_hash = in.U64();
  if (!IsFinite(hello.field_lsb_T) || !IsFinite(hello.current_max_A)) return Status::kNotFinite;
  if (!IsPositive(hello.field_lsb_T) || !IsPositive(hello.current_max_A)) return Status::kOutOfRange;
  if (hello.version_min > hello.version_max || hello.field_full_scale == 0) return Status::kOutOfRange;
  message = hello;
  return Status::kOk;
}

Encoded EncodeTelemetry(const Telemetry& telemetry, std::uint16_t seq, std::uint64_t t_device_us, std::uint8_t* frame,
                        std::size_t capacity) noexcept {
  if (capacity < kHeaderSize) return {Status::kNoRoom, 0};
  ByteWriter out(frame + kHeaderSize, PayloadCapacity(capacity));
  for (const auto& sensor : telemetry.field) {
    for (const std::int16_t counts : sensor) out.I16(counts);
  }
  out.U8(telemetry.fresh_mask);
  out.U8(static_cast<std::uint8_t>(telemetry.state));
  for (const std::uint8_t age : telemetry.age) out.U8(age);
  out.U32(telemetry.saturated_mask);
  for (const std::int16_t current : telemetry.current) out.I16(current);
  for (const std::int16_t temperature : telemetry.temperature) out.I16(temperature);
  out.U16(telemetry.supply);
  out.U32(telemetry.faults);
  out.U16(telemetry.ack_seq);
  out.U64(telemetry.ack_host_us);
  out.U16(telemetry.rejected);
  out.U16(telemetry.missed_ticks);
  return Finish(MessageType::kTelemetry, seq, t_device_us, out, frame, capacity);
}

Status DecodeTelemetry(const FrameView& view, Telemetry& message) noexcept {
  const Status status = CheckView(view, MessageType::kTelemetry, kTelemetryPayloadSize);
  if (status != Status::kOk) return status;
  ByteReader in(view.payload, view.payload_size);
  Telemetry telemetry;
  for (auto& sensor : telemetry.field) {
    for (std::int16_t& counts : sensor) counts = in.I16();
  }
  telemetry.fresh_mask = in.U8();
  const std::uint8_t state = in.U8();
  if (state > static_cast<std::uint8_t>(State::kFault)) return Status::kOutOfRange;
  telemetry.state = static_cast<State>(state);
  for (std::uint8_t& age : telemetry.age) age = in.U8();
  telemetry.saturated_mask = in.U32();
  for (std::int16_t& current : telemetry.current) current = in.I16();
  for (std::int16_t& temperature : telemetry.temperature) temperature = in.I16();
  telemetry.supply = in.U16();
  telemetry.faults = in.U32();
  telemetry.ack_seq = in.U16();
  telemetry.ack_host_us = in.U64();
  telemetry.rejected = in.U16();
  telemetry.missed_ticks = in.U16();
  if ((telemetry.saturated_mask >> (3 * kSensors)) != 0) return Status::kOutOfRange;
  message = telemetry;
  return Status::kOk;
}

Status CheckCommand(const Command& command, float current_max_A) noexcept {
  if (command.mode != Mode::kOff && command.mode != Mode::kCurrent) return Status::kOutOfRange;
  if (!(command.time_to_live_ms >= 1 && command.time_to_live_ms <= kTimeToLiveMax_ms)) return Status::kOutOfRange;
  for (const float set_point : command.set_point_A) {
    if (!IsFinite(set_point)) return Status::kNotFinite;
    if (!(set_point >= -current_max_A && set_point <= current_max_A)) return Status::kOutOfRange;
  }
  return Status::kOk;
}

Encoded EncodeCommand(const Command& command, float current_max_A, std::uint16_t seq, std::uint8_t* frame,
                      std::size_t capacity) noexcept {
  const Status status = CheckCommand(command, current_max_A);
  if (status != Status::kOk) return {status, 0};
  if (capacity < kHeaderSize) return {Status::kNoRoom, 0};
  ByteWriter out(frame + kHeaderSize, PayloadCapacity(capacity));
  out.U8(static_cast<std::uint8_t>(command.mode));
  out.U8(command.flags);
  out.U16(command.time_to_live_ms);
  for (const float set_point : command.set_point_A) out.F32(set_point);
  out.U64(command.host_us);
  out.U64(command.echo_device_us);
  return Finish(MessageType::kCommand, seq, 0, out, frame, capacity);
}

Status DecodeCommand(const FrameView& view, float current_max_A, Command& message) noexcept {
  const Status status = CheckView(view, MessageType::kCommand, kCommandPayloadSize);
  if (status != Status::kOk) return status;
  ByteReader in(view.payload, view.payload_size);
  Command command;
  command.mode = static_cast<Mode>(in.U8());
  command.flags = in.U8();
  command.time_to_live_ms = in.U16();
  for (float& set_point : command.set_point_A) set_point = in.F32();
  command.host_us = in.U64();
  command.echo_device_us = in.U64();
  const Status content = CheckCommand(command, current_max_A);
  if (content != Status::kOk) return content;
  message = command;
  return Status::kOk;
}

}  // namespace omni::wire
