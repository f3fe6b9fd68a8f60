#include "firmware/wire/frame.h"

#include "firmware/wire/bytes.h"

namespace omni::wire {
namespace {

constexpr std::uint32_t kPolynomialReflected = 0x82F63B78U;

struct Table {
  std::uint32_t entry[256];
};

constexpr Table MakeTable() {
  Table table{};
  for (std::uint32_t byte = 0; byte < 256; ++byte) {
    std::uint32_t crc = byte;
    for (int bit = 0; bit < 8; ++bit) crc = (crc >> 1) ^ ((crc & 1U) != 0 ? kPolynomialReflected : 0U);
    table.entry[byte] = crc;
  }
  return table;
}

constexpr Table kTable = MakeTable();

bool IsKnown(std::uint8_t type) noexcept {
  switch (static_cast<MessageType>(type)) {
    case MessageType::kHello:
    case MessageType::kTelemetry:
    case MessageType::kCommand:
    case MessageType::kConfig:
    case MessageType::kArm:
    case MessageType::kEstop:
    case MessageType::kFault:
    case MessageType::kLog:
      return true;
  }
  return false;
}

}  // namespace

std::uint32_t Crc32c(const std::uint8_t* data, std::size_t size) noexcept {
  std::uint32_t crc = 0xFFFFFFFFU;
  for (std::size_t i = 0; i < size; ++i) crc = (crc >> 8) ^ kTable.entry[(crc ^ data[i]) & 0xFFU];
  return ~crc;
}

const char* StatusName(Status status) noexcept {
  switch (status) {
    case Status::kOk:
      return "ok";
    case Status::kTooShort:
      return "frame too short";
    case Status::kTooLong:
      return "frame too long";
    case Status::kBadMagic:
      return "bad magic";
    case Status::kBadVersion:
      return "other protocol version";
    case Status::kBadLength:
      return "payload length disagrees with the transfer";
    case Status::kBadCrc:
      return "bad CRC";
    case Status::kUnknownType:
      return "unknown message type";
    case Status::kWrongType:
      return "another message type was expected";
    case Status::kShortPayload:
      return "payload too short";
    case Status::kNotFinite:
      return "value is not finite";
    case Status::kOutOfRange:
      return "value out of range";
    case Status::kNoRoom:
      return "buffer too small";
  }
  return "unknown status";
}

Status OpenFrame(const std::uint8_t* data, std::size_t size, FrameView& view) noexcept {
  if (size < kHeaderSize + kTrailerSize) return Status::kTooShort;
  if (size > kFrameSizeMax) return Status::kTooLong;
  ByteReader reader(data, kHeaderSize);
  if (reader.U16() != kMagic) return Status::kBadMagic;
  const std::uint8_t version = reader.U8();
  const std::uint8_t type = reader.U8();
  if (version != kVersion && type != static_cast<std::uint8_t>(MessageType::kHello)) return Status::kBadVersion;
  Header header;
  header.seq = reader.U16();
  const std::size_t payload_size = reader.U16();
  header.t_device_us = reader.U64();
  if (payload_size != size - kHeaderSize - kTrailerSize) return Status::kBadLength;
  ByteReader trailer(data + size - kTrailerSize, kTrailerSize);
  if (trailer.U32() != Crc32c(data, size - kTrailerSize)) return Status::kBadCrc;
  if (!IsKnown(type)) return Status::kUnknownType;
  header.type = static_cast<MessageType>(type);
  view.header = header;
  view.payload = data + kHeaderSize;
  view.payload_size = payload_size;
  return Status::kOk;
}

Encoded SealFrame(const Header& header, std::size_t payload_size, std::uint8_t* frame, std::size_t capacity) noexcept {
  const std::size_t size = kHeaderSize + payload_size + kTrailerSize;
  if (payload_size > kPayloadSizeMax || size > capacity) return {Status::kNoRoom, 0};
  ByteWriter writer(frame, kHeaderSize);
  writer.U16(kMagic);
  writer.U8(kVersion);
  writer.U8(static_cast<std::uint8_t>(header.type));
  writer.U16(header.seq);
  writer.U16(static_cast<std::uint16_t>(payload_size));
  writer.U64(header.t_device_us);
  ByteWriter trailer(frame + kHeaderSize + payload_size, kTrailerSize);
  trailer.U32(Crc32c(frame, kHeaderSize + payload_size));
  return {Status::kOk, size};
}

}  // namespace omni::wire
