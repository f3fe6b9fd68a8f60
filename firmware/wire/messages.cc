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

class FieldWriter {
 public:
  explicit FieldWriter(ByteWriter& out) noexcept : out_(out) {}
  template <class Field>
  void operator()(const char*, const Field& field, const char*, const char*) noexcept {
    Put(field);
  }

 private:
  template <class Field>
  void Put(const Field& field) noexcept {
    if constexpr (std::is_array_v<Field>) {
      for (const auto& element : field) Put(element);
    } else if constexpr (std::is_same_v<Field, float>) {
      out_.F32(field);
    } else if constexpr (sizeof(Field) == 1) {
      out_.U8(static_cast<std::uint8_t>(field));
    } else if constexpr (sizeof(Field) == 2) {
      out_.U16(static_cast<std::uint16_t>(field));
    } else if constexpr (sizeof(Field) == 4) {
      out_.U32(static_cast<std::uint32_t>(field));
    } else {
      out_.U64(static_cast<std::uint64_t>(field));
    }
  }

  ByteWriter& out_;
};

class FieldReader {
 public:
  explicit FieldReader(ByteReader& in) noexcept : in_(in) {}
  template <class Field>
  void operator()(const char*, Field& field, const char*, const char*) noexcept {
    Get(field);
  }
  bool finite() const noexcept { return finite_; }

 private:
  template <class Field>
  void Get(Field& field) noexcept {
    if constexpr (std::is_array_v<Field>) {
      for (auto& element : field) Get(element);
    } else if constexpr (std::is_same_v<Field, float>) {
      field = in_.F32();
      finite_ = finite_ && IsFinite(field);
    } else if constexpr (sizeof(Field) == 1) {
      field = static_cast<Field>(in_.U8());
    } else if constexpr (sizeof(Field) == 2) {
      field = static_cast<Field>(in_.U16());
    } else if constexpr (sizeof(Field) == 4) {
      field = static_cast<Field>(in_.U32());
    } else {
      field = static_cast<Field>(in_.U64());
    }
  }

  ByteReader& in_;
  bool finite_ = true;
};

// Room for the payload in `frame`; 0 when not even the header fits.
std::size_t PayloadCapacity(std::size_t capacity) noexcept {
  return capacity < kHeaderSize + kTrailerSize ? 0 : capacity - kHeaderSize - kTrailerSize;
}

template <class Enum>
bool IsWithin(Enum value, Enum first, Enum last) noexcept {
  return value >= first && value <= last;
}

// Range checks of a message's numbers, beyond being finite.
bool IsValid(const Hello& hello) noexcept {
  return IsPositive(hello.field_lsb_T) && IsPositive(hello.current_max_A) && hello.version_min <= hello.version_max &&
         hello.field_full_scale > 0 && hello.field_full_scale <= 0x7FFF;
}
bool IsValid(const Telemetry& telemetry) noexcept {
  return telemetry.state <= State::kFault && (telemetry.saturated_mask >> (3 * kSensors)) == 0;
}
bool IsValid(const Command& command) noexcept {
  return command.mode <= Mode::kCurrent && command.time_to_live_ms >= 1 && command.time_to_live_ms <= kTimeToLiveMax_ms;
}
bool IsValid(const Config& config) noexcept { return IsWithin(config.op, ConfigOp::kGet, ConfigOp::kRefused); }
bool IsValid(const Arm& arm) noexcept { return IsWithin(arm.step, ArmStep::kRequest, ArmStep::kRefused); }
bool IsValid(const Estop&) noexcept { return true; }
bool IsValid(const FaultEvent& event) noexcept { return event.state <= State::kFault; }
bool IsValid(const Log& log) noexcept { return log.level <= LogLevel::kError && log.size <= kLogTextMax; }

}  // namespace

template <class Message>
Encoded Encode(const Message& message, std::uint16_t seq, std::uint64_t t_device_us, std::uint8_t* frame,
               std::size_t capacity) noexcept {
  if (capacity < kHeaderSize) return {Status::kNoRoom, 0};
  ByteWriter out(frame + kHeaderSize, PayloadCapacity(capacity));
  FieldWriter writer(out);
  Message::Visit(message, writer);
  if (!out.ok()) return {Status::kNoRoom, 0};
  Header header;
  header.type = Message::kType;
  header.seq = seq;
  header.t_device_us = t_device_us;
  return SealFrame(header, out.size(), frame, capacity);
}

template <class Message>
Status Decode(const FrameView& view, Message& message) noexcept {
  if (view.header.type != Message::kType) return Status::kWrongType;
  if (view.payload_size < PayloadSize<Message>()) return Status::kShortPayload;
  ByteReader in(view.payload, view.payload_size);
  FieldReader reader(in);
  Message decoded;
  Message::Visit(decoded, reader);
  if (!reader.finite()) return Status::kNotFinite;
  if (!IsValid(decoded)) return Status::kOutOfRange;
  message = decoded;
  return Status::kOk;
}

// NOLINTBEGIN(bugprone-macro-parentheses): a type
#define OMNI_WIRE_MESSAGE(Message)                                                                            \
  template Encoded Encode(const Message&, std::uint16_t, std::uint64_t, std::uint8_t*, std::size_t) noexcept; \
  template Status Decode(const FrameView&, Message&) noexcept;
// NOLINTEND(bugprone-macro-parentheses)
OMNI_WIRE_MESSAGE(Hello)
OMNI_WIRE_MESSAGE(Telemetry)
OMNI_WIRE_MESSAGE(Command)
OMNI_WIRE_MESSAGE(Config)
OMNI_WIRE_MESSAGE(Arm)
OMNI_WIRE_MESSAGE(Estop)
OMNI_WIRE_MESSAGE(FaultEvent)
OMNI_WIRE_MESSAGE(Log)
#undef OMNI_WIRE_MESSAGE

Status CheckCommand(const Command& command, float current_max_A) noexcept {
  if (!IsValid(command)) return Status::kOutOfRange;
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
  return Encode(command, seq, 0, frame, capacity);
}

Status DecodeCommand(const FrameView& view, float current_max_A, Command& message) noexcept {
  Command command;
  const Status decoded = Decode(view, command);
  if (decoded != Status::kOk) return decoded;
  const Status content = CheckCommand(command, current_max_A);
  if (content != Status::kOk) return content;
  message = command;
  return Status::kOk;
}

}  // namespace omni::wire
