// The messages, with values in wire units (their units are below). Every message lists its fields once, in wire
// order (Visit): encoding, decoding, sizes and docs/protocol/wire.md are all derived from that.
#pragma once

#include <cstddef>
#include <cstdint>
#include <limits>
#include <type_traits>

#include "firmware/wire/frame.h"

namespace omni::wire {

// The wire's units, and rounding to them without a maths library.
constexpr double kCurrentUnit_A = 1.25e-3;  // INA260
constexpr double kSupplyUnit_V = 1.25e-3;   // INA260
constexpr double kTemperatureUnit_K = 0.01;
constexpr std::int64_t kAgeUnit_ns = 20'000;

// Nearest count of value / unit, clipped to what Count can hold; NaN gives 0.
template <class Count>
constexpr Count ToCounts(double value, double unit) noexcept {
  const double counts = value / unit;
  constexpr double kMin = static_cast<double>(std::numeric_limits<Count>::min());
  constexpr double kMax = static_cast<double>(std::numeric_limits<Count>::max());
  if (counts >= kMax) return std::numeric_limits<Count>::max();
  if (counts <= kMin) return std::numeric_limits<Count>::min();
  if (!(counts > kMin && counts < kMax)) return 0;
  return static_cast<Count>(counts >= 0 ? counts + 0.5 : counts - 0.5);
}

constexpr int kSensors = 8;
constexpr int kCoils = 3;
constexpr int kStepsPerTick = 4;  // control steps, evenly spaced; the last ends with the tick
constexpr std::uint16_t kTimeToLiveMax_ms = 20;
constexpr std::int16_t kDutyFull = 32767;
constexpr std::size_t kLogTextMax = 120;
constexpr std::uint8_t kWholeBase = 255;  // FaultEvent::part

// Capability bits of HELLO.
constexpr std::uint32_t kDeviceClockIsHostMonotonic = 1U << 0;  // t_device_us is the host's CLOCK_MONOTONIC
constexpr std::uint32_t kSimulation = 1U << 1;                  // no hardware behind it
constexpr std::uint32_t kCurrentSensors = 1U << 2;              // coil currents are measured, one sensor per coil
constexpr std::uint32_t kArming = 1U << 3;                      // coils stay at zero until ARM

// Fault bits of TELEMETRY. While any is set, the base holds its coils at zero. A bit stays set until ARM finds its
// cause gone; the first two are not failures: the host arms again automatically.
enum Fault : std::uint32_t {
  kFaultNotArmed = 1U << 0,         // no error: the base has not been armed
  kFaultHostSilent = 1U << 1,       // no valid COMMAND within its time to live
  kFaultOverTemperature = 1U << 2,  // of a coil, by its resistance or by the heat model; or of the board
  kFaultOverCurrent = 1U << 3,      // of a coil, or the sensor's own alert
  kFaultDriver = 1U << 4,           // an H bridge reports a fault
  kFaultSupplyLow = 1U << 5,
  kFaultSupplyHigh = 1U << 6,
  kFaultPower = 1U << 7,           // all coils together
  kFaultCoilOpen = 1U << 8,        // voltage but no current
  kFaultCoilShort = 1U << 9,       // more current than the voltage explains
  kFaultModel = 1U << 10,          // current does not follow its set-point
  kFaultCurrentSensor = 1U << 11,  // does not answer, or reports impossible values
  kFaultHallSensor = 1U << 12,     // does not answer, has the wrong identity or no fresh sample
  kFaultHallStuck = 1U << 13,      // repeats the same sample
  kFaultHallJump = 1U << 14,       // changed faster than a moving magnet can cause
  kFaultFan = 1U << 15,            // does not turn although it should
  kFaultEmergencyStop = 1U << 16,  // the switch, ESTOP, or the vendor request of endpoint 0
  kFaultSelfTest = 1U << 17,       // failed at boot
  kFaultWatchdog = 1U << 18,       // it caused the last reset
  kFaultInternal = 1U << 19,       // a number that is not finite, a corrupt record, a bridge driven while not armed
};
constexpr std::uint32_t kFaultsOfTheHost = kFaultNotArmed | kFaultHostSilent;

enum class State : std::uint8_t { kBoot = 0, kSelfTest = 1, kIdle = 2, kArmed = 3, kFault = 4 };
enum class Mode : std::uint8_t { kOff = 0, kCurrent = 1 };
// Two steps, so that no single frame, however it was produced, can arm.
enum class ArmStep : std::uint8_t { kRequest = 1, kChallenge = 2, kConfirm = 3, kArmed = 4, kRefused = 5 };
enum class ConfigOp : std::uint8_t { kGet = 1, kSet = 2, kValue = 3, kRefused = 4 };
enum class LogLevel : std::uint8_t { kDebug = 0, kInfo = 1, kWarning = 2, kError = 3 };

enum class ConfigId : std::uint16_t {
  kCurrentMax_A = 1,
  kSlewMax_A_s = 2,
  kPowerMax_W = 3,
  kTemperatureDerate_C = 4,
  kTemperatureMax_C = 5,
  kResistance20_ohm = 0x10,  // + coil
  kInductance_H = 0x20,      // + coil
};

// The base's identity; requested by an empty HELLO. The same layout in all versions.
struct Hello {
  static constexpr MessageType kType = MessageType::kHello;
  std::uint8_t version_min = kVersion;
  std::uint8_t version_max = kVersion;
  std::uint16_t firmware_version = 0;
  std::uint32_t capabilities = 0;
  char serial[16] = {};
  float field_lsb_T = 0;
  std::uint16_t field_full_scale = 0;
  std::uint16_t reserved = 0;
  float current_max_A = 0;
  std::uint64_t calibration_hash = 0;

  template <class Self, class Visitor>
  static constexpr void Visit(Self& self, Visitor&& visit) {
    visit("version_min", self.version_min, "", "oldest protocol version that the sender speaks");
    visit("version_max", self.version_max, "", "newest");
    visit("firmware_version", self.firmware_version, "", "major * 256 + minor");
    visit("capabilities", self.capabilities, "bits", "of Capability");
    visit("serial", self.serial, "", "text, not necessarily terminated");
    visit("field_lsb_T", self.field_lsb_T, "T", "of one count of `field`");
    visit("field_full_scale", self.field_full_scale, "counts", "a larger value is saturated");
    visit("reserved", self.reserved, "", "0");
    visit("current_max_A", self.current_max_A, "A", "largest set-point");
    visit("calibration_hash", self.calibration_hash, "", "0: field counts are nominal");
  }
};

// Base to host, 1 kHz.
struct Telemetry {
  static constexpr MessageType kType = MessageType::kTelemetry;
  std::int16_t field[kSensors][3] = {};
  std::uint8_t fresh_mask = 0;
  State state = State::kIdle;
  std::uint8_t age[kSensors] = {};
  std::uint32_t saturated_mask = 0;
  std::int16_t current[kStepsPerTick][kCoils] = {};
  std::int16_t temperature[kCoils] = {};
  std::uint16_t supply = 0;
  std::uint32_t faults = 0;
  std::uint16_t ack_seq = 0;
  std::uint64_t ack_host_us = 0;
  std::uint16_t rejected = 0;
  std::uint16_t missed_ticks = 0;
  std::uint16_t voltage[kCoils] = {};
  std::uint16_t resistance[kCoils] = {};
  std::int16_t duty[kCoils] = {};
  std::int16_t board_temperature = 0;
  std::uint16_t fan_rpm = 0;
  std::uint32_t ack_rx_device_us = 0;
  std::uint16_t tick_lead = 0;

  template <class Self, class Visitor>
  static constexpr void Visit(Self& self, Visitor&& visit) {
    visit("field", self.field, "counts", "in each sensor's own frame");
    visit("fresh_mask", self.fresh_mask, "bits", "i: sensor i has a new sample since the last frame");
    visit("state", self.state, "", "of State");
    visit("age", self.age, "20 us", "of that sensor's sample at t_device_us; 255: that or older");
    visit("saturated_mask", self.saturated_mask, "bits", "3 i + axis");
    visit("current", self.current, "1.25 mA",
          "at the end of each control step, oldest first; the last: at the tick's end");
    visit("temperature", self.temperature, "0.01 C", "of the copper");
    visit("supply", self.supply, "1.25 mV", "");
    visit("faults", self.faults, "bits", "of Fault");
    visit("ack_seq", self.ack_seq, "", "of the last accepted COMMAND");
    visit("ack_host_us", self.ack_host_us, "us", "its host_us");
    visit("rejected", self.rejected, "", "frames refused, wraps");
    visit("missed_ticks", self.missed_ticks, "", "device ticks that produced no frame, wraps");
    visit("voltage", self.voltage, "1.25 mV", "across each coil, mean over the tick, without sign");
    visit("resistance", self.resistance, "0.1 mohm", "of each coil, tracked");
    visit("duty", self.duty, "1/32767", "sign: direction");
    visit("board_temperature", self.board_temperature, "0.01 C", "");
    visit("fan_rpm", self.fan_rpm, "1/min", "");
    visit("ack_rx_device_us", self.ack_rx_device_us, "us", "device time at which that COMMAND came, low 32 bits");
    visit("tick_lead", self.tick_lead, "us", "from t_device_us to the tick's end");
  }
};

// Host to base: set-points that hold for at most their time to live.
struct Command {
  static constexpr MessageType kType = MessageType::kCommand;
  Mode mode = Mode::kOff;
  std::uint8_t flags = 0;
  std::uint16_t time_to_live_ms = kTimeToLiveMax_ms;
  float set_point_A[kCoils] = {};
  std::uint64_t host_us = 0;
  std::uint64_t echo_device_us = 0;

  template <class Self, class Visitor>
  static constexpr void Visit(Self& self, Visitor&& visit) {
    visit("mode", self.mode, "", "of Mode");
    visit("flags", self.flags, "bits", "0");
    visit("time_to_live_ms", self.time_to_live_ms, "ms", "1 to 20");
    visit("set_point_A", self.set_point_A, "A", "finite, within HELLO's current_max_A");
    visit("host_us", self.host_us, "us", "host clock at sending");
    visit("echo_device_us", self.echo_device_us, "us", "t_device_us of the telemetry that this answers");
  }
};

// Get, set (idle only) or report one setting.
struct Config {
  static constexpr MessageType kType = MessageType::kConfig;
  ConfigOp op = ConfigOp::kGet;
  std::uint8_t reserved = 0;
  std::uint16_t id = 0;
  float value = 0;

  template <class Self, class Visitor>
  static constexpr void Visit(Self& self, Visitor&& visit) {
    visit("op", self.op, "", "of ConfigOp; the base answers kValue or kRefused");
    visit("reserved", self.reserved, "", "0");
    visit("id", self.id, "", "of ConfigId, plus the coil where it is per coil");
    visit("value", self.value, "", "in the unit that the id names; always the value in force");
  }
};

// Host: request, confirm with the nonce of the challenge. Base: challenge, armed or refused with the reasons.
struct Arm {
  static constexpr MessageType kType = MessageType::kArm;
  ArmStep step = ArmStep::kRequest;
  std::uint8_t version = kVersion;
  std::uint16_t reserved = 0;
  std::uint32_t nonce = 0;
  std::uint32_t faults = 0;

  template <class Self, class Visitor>
  static constexpr void Visit(Self& self, Visitor&& visit) {
    visit("step", self.step, "", "of ArmStep");
    visit("version", self.version, "", "protocol version that the sender speaks; another one is refused");
    visit("reserved", self.reserved, "", "0");
    visit("nonce", self.nonce, "", "of the challenge, good for one confirmation within 100 ms");
    visit("faults", self.faults, "bits", "of Fault: why it is refused");
  }
};

// Emergency stop: brake now, latched until ARM. May be sent any number of times.
struct Estop {
  static constexpr MessageType kType = MessageType::kEstop;
  std::uint8_t reason = 0;

  template <class Self, class Visitor>
  static constexpr void Visit(Self& self, Visitor&& visit) {
    visit("reason", self.reason, "", "for the fault record");
  }
};

// A new fault, and on request (empty FAULT from the host) the one recorded before the last reset.
struct FaultEvent {
  static constexpr MessageType kType = MessageType::kFault;
  std::uint32_t fault = 0;
  std::uint32_t faults = 0;
  State state = State::kBoot;
  std::uint8_t part = 0;
  std::uint8_t after_reset = 0;
  std::uint8_t reserved = 0;
  float value = 0;
  std::uint64_t t_us = 0;

  template <class Self, class Visitor>
  static constexpr void Visit(Self& self, Visitor&& visit) {
    visit("fault", self.fault, "bit", "of Fault, the new one; 0: none recorded");
    visit("faults", self.faults, "bits", "all, with it");
    visit("state", self.state, "", "in which it came");
    visit("part", self.part, "", "coil or sensor; 255: the whole base");
    visit("after_reset", self.after_reset, "", "1: from before the last reset");
    visit("reserved", self.reserved, "", "0");
    visit("value", self.value, "", "what was measured, in SI");
    visit("t_us", self.t_us, "us", "device time");
  }
};

struct Log {
  static constexpr MessageType kType = MessageType::kLog;
  LogLevel level = LogLevel::kInfo;
  std::uint8_t size = 0;
  char text[kLogTextMax] = {};

  template <class Self, class Visitor>
  static constexpr void Visit(Self& self, Visitor&& visit) {
    visit("level", self.level, "", "of LogLevel");
    visit("size", self.size, "bytes", "of the text");
    visit("text", self.text, "", "printable ASCII");
  }
};

namespace internal {

struct SizeOf {
  std::size_t size = 0;
  template <class Field>
  constexpr void operator()(const char*, const Field&, const char*, const char*) {
    size += sizeof(Field);  // fields have no padding: integers, floats, enums and arrays of them
  }
};

}  // namespace internal

template <class Message>
constexpr std::size_t PayloadSize() {
  internal::SizeOf size;
  const Message message{};
  Message::Visit(message, size);
  return size.size;
}
template <class Message>
constexpr std::size_t FrameSize() {
  return kHeaderSize + PayloadSize<Message>() + kTrailerSize;
}
static_assert(FrameSize<Telemetry>() <= 160 && FrameSize<Command>() <= 64, "budget of the 1 kHz stream");

// For the eight messages above. Floats must be finite; Decode refuses others.
template <class Message>
Encoded Encode(const Message& message, std::uint16_t seq, std::uint64_t t_device_us, std::uint8_t* frame,
               std::size_t capacity) noexcept;

// `message` is filled only on kOk: the right type, whole, numbers finite, enums and masks within their range.
template <class Message>
Status Decode(const FrameView& view, Message& message) noexcept;

// Mode known, time to live 1..20 ms, every set-point finite and |I| <= current_max_A. Encoding refuses what decoding
// would refuse, so that an invalid value is never sent.
Status CheckCommand(const Command& command, float current_max_A) noexcept;
Encoded EncodeCommand(const Command& command, float current_max_A, std::uint16_t seq, std::uint8_t* frame,
                      std::size_t capacity) noexcept;
Status DecodeCommand(const FrameView& view, float current_max_A, Command& message) noexcept;

}  // namespace omni::wire
