// What travels: HELLO (who the base is), TELEMETRY (1 kHz, base -> host), COMMAND (host -> base).
// Values are wire units here; scaling.h says what one unit is.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/wire/frame.h"

namespace omni::wire {

constexpr int kSensors = 8;
constexpr int kCoils = 3;
constexpr std::uint16_t kTimeToLiveMax_ms = 20;

// Capability bits of HELLO.
constexpr std::uint32_t kDeviceClockIsHostMonotonic = 1U << 0;  // t_device_us is the host's CLOCK_MONOTONIC
constexpr std::uint32_t kSimulation = 1U << 1;                  // no hardware behind it
constexpr std::uint32_t kCurrentSensors = 1U << 2;              // coil currents are measured, one sensor per coil

// Fault bits of TELEMETRY. Any bit: the base holds its coils at zero.
enum Fault : std::uint32_t {
  kFaultHostSilent = 1U << 0,       // no valid COMMAND within its time to live; ends with the next valid one
  kFaultOverTemperature = 1U << 1,  // ends when the copper has cooled below the derating temperature
  kFaultSensor = 1U << 2,           // a Hall sensor does not answer
};

enum class State : std::uint8_t { kIdle = 0, kDriving = 1, kFault = 2 };

struct Hello {
  std::uint8_t version_min = kVersion;
  std::uint8_t version_max = kVersion;
  std::uint16_t firmware_version = 0;
  std::uint32_t capabilities = 0;
  char serial[16] = {};  // not necessarily terminated
  float field_lsb_T = 0;
  std::uint16_t field_full_scale = 0;  // counts
  float current_max_A = 0;
  std::uint64_t calibration_hash = 0;  // 0: field counts are nominal
};

struct Telemetry {
  std::int16_t field[kSensors][3] = {};  // counts, in each sensor's own frame
  std::uint8_t fresh_mask = 0;           // bit i: sensor i has a new sample since the last frame
  State state = State::kIdle;
  std::uint8_t age[kSensors] = {};   // of that sensor's sample at t_device_us, in kAgeUnit_ns; 255: that or older
  std::uint32_t saturated_mask = 0;  // bit 3 i + axis
  std::int16_t current[kCoils] = {};
  std::int16_t temperature[kCoils] = {};  // copper
  std::uint16_t supply = 0;
  std::uint32_t faults = 0;
  std::uint16_t ack_seq = 0;       // of the last accepted COMMAND
  std::uint64_t ack_host_us = 0;   // its host_us
  std::uint16_t rejected = 0;      // COMMAND frames refused, wraps
  std::uint16_t missed_ticks = 0;  // device ticks that produced no frame, wraps
};

enum class Mode : std::uint8_t { kOff = 0, kCurrent = 1 };

struct Command {
  Mode mode = Mode::kOff;
  std::uint8_t flags = 0;
  std::uint16_t time_to_live_ms = kTimeToLiveMax_ms;  // 1..20
  float set_point_A[kCoils] = {};
  std::uint64_t host_us = 0;         // host clock at sending
  std::uint64_t echo_device_us = 0;  // t_device_us of the telemetry that this command answers
};

constexpr std::size_t kHelloPayloadSize = 44;
constexpr std::size_t kTelemetryPayloadSize = 94;
constexpr std::size_t kCommandPayloadSize = 32;
constexpr std::size_t kTelemetryFrameSize = kHeaderSize + kTelemetryPayloadSize + kTrailerSize;
constexpr std::size_t kCommandFrameSize = kHeaderSize + kCommandPayloadSize + kTrailerSize;
static_assert(kTelemetryFrameSize <= 160 && kCommandFrameSize <= 64, "budget of the 1 kHz stream");

Encoded EncodeHello(const Hello& hello, std::uint16_t seq, std::uint64_t t_device_us, std::uint8_t* frame,
                    std::size_t capacity) noexcept;
Encoded EncodeTelemetry(const Telemetry& telemetry, std::uint16_t seq, std::uint64_t t_device_us, std::uint8_t* frame,
                        std::size_t capacity) noexcept;
// Refuses what DecodeCommand would refuse, so that a bad value never leaves the host.
Encoded EncodeCommand(const Command& command, float current_max_A, std::uint16_t seq, std::uint8_t* frame,
                      std::size_t capacity) noexcept;

// `message` is filled only on kOk.
Status DecodeHello(const FrameView& view, Hello& message) noexcept;
Status DecodeTelemetry(const FrameView& view, Telemetry& message) noexcept;
Status DecodeCommand(const FrameView& view, float current_max_A, Command& message) noexcept;

// Mode known, time to live 1..20 ms, every set-point finite and |I| <= current_max_A.
Status CheckCommand(const Command& command, float current_max_A) noexcept;

}  // namespace omni::wire
