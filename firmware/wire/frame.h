// The envelope of every frame between host and base, little endian. One frame is one USB transfer or one seqpacket
// datagram, always < 512 bytes, so no further framing is needed:
//
//   u16 magic | u8 version | u8 type | u16 seq | u16 payload_len | u64 t_device_us | payload | u32 CRC-32C of all
//   bytes before it
//
// Unknown trailing bytes of a payload are ignored (a newer minor version may append fields); another version is
// refused, except in HELLO, whose layout never changes: both sides can see which of them is older.
#pragma once

#include <cstddef>
#include <cstdint>

namespace omni::wire {

constexpr std::uint16_t kMagic = 0x4D4F;  // "OM"
constexpr std::uint8_t kVersion = 1;
constexpr std::size_t kHeaderSize = 16;
constexpr std::size_t kTrailerSize = 4;
constexpr std::size_t kFrameSizeMax = 511;
constexpr std::size_t kPayloadSizeMax = kFrameSizeMax - kHeaderSize - kTrailerSize;

enum class MessageType : std::uint8_t {
  kHello = 1,
  kTelemetry = 2,
  kCommand = 3,
  kConfig = 4,
  kArm = 5,
  kEstop = 6,
  kFault = 7,
  kLog = 8
};

enum class Status : std::uint8_t {
  kOk = 0,
  kTooShort,  // less than header + trailer
  kTooLong,   // more than kFrameSizeMax
  kBadMagic,
  kBadVersion,
  kBadLength,  // payload_len disagrees with the size of the transfer
  kBadCrc,
  kUnknownType,   // a valid frame of a type unknown to this build: ignore it
  kWrongType,     // a known type, but not the expected one
  kShortPayload,  // payload smaller than the message's fields
  kNotFinite,     // NaN or infinity in a set-point
  kOutOfRange,    // a field outside its stated range
  kNoRoom         // encoding: the buffer is too small
};

const char* StatusName(Status status) noexcept;

struct Header {
  MessageType type = MessageType::kHello;
  std::uint16_t seq = 0;          // per direction and type-independent; compare with SeqDistance
  std::uint64_t t_device_us = 0;  // TELEMETRY: instant of the newest Hall sample. COMMAND: 0
};

struct FrameView {
  Header header;
  const std::uint8_t* payload = nullptr;
  std::size_t payload_size = 0;
};

// Checks the whole envelope. `view` points into `data`; it is filled only on kOk.
Status OpenFrame(const std::uint8_t* data, std::size_t size, FrameView& view) noexcept;

struct Encoded {
  Status status = Status::kOk;
  std::size_t size = 0;  // bytes written; 0 unless kOk
};

// Wraps `payload_size` bytes that already stand at `frame + kHeaderSize`.
Encoded SealFrame(const Header& header, std::size_t payload_size, std::uint8_t* frame, std::size_t capacity) noexcept;

// Serial-number arithmetic [RFC 1982]: how many steps `b` is after `a`; negative: before.
inline std::int32_t SeqDistance(std::uint16_t a, std::uint16_t b) noexcept {
  return static_cast<std::int16_t>(static_cast<std::uint16_t>(b - a));
}

// CRC-32C (Castagnoli): polynomial 0x1EDC6F41 reflected, start and final value 0xFFFFFFFF [RFC 3720, B.4].
std::uint32_t Crc32c(const std::uint8_t* data, std::size_t size) noexcept;

}  // namespace omni::wire
