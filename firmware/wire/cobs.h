// Consistent Overhead Byte Stuffing [Cheshire, Baker: IEEE/ACM Trans. Networking 7(2), 1999]: frames over links without
// packet boundaries (UART, pty). A packet contains no zero byte; one zero ends it. After noise, or when a receiver
// joins in the middle, at most the packets that the noise touched are lost: the next zero is a boundary again.
//
//   packet = blocks, block = u8 code | code - 1 bytes that are not zero; between blocks there is a zero of the data,
//   unless the code of the first of them is 255. The zero after the last block is not part of the data.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/wire/frame.h"

namespace omni::wire {

constexpr std::uint8_t kCobsEnd = 0;
constexpr std::size_t kCobsBlockMax = 254;  // data bytes of one block

// Largest packet of `size` bytes of data, without its end.
constexpr std::size_t CobsSizeMax(std::size_t size) noexcept {
  return size == 0 ? 1 : size + (size + kCobsBlockMax - 1) / kCobsBlockMax;
}
constexpr std::size_t kCobsFrameSizeMax = CobsSizeMax(kFrameSizeMax);

// The packet without its end; returns its size, 0 when it does not fit `capacity`. A sender writes kCobsEnd after each
// packet, and one before the first, which ends whatever was on the line before.
std::size_t CobsEncode(const std::uint8_t* data, std::size_t size, std::uint8_t* packet, std::size_t capacity) noexcept;

// Bytes in, packets out. Anything that is not a packet, or is longer than a frame, is counted and dropped. A packet
// that noise joined from two halves is returned: the CRC detects it.
class CobsReceiver {
 public:
  // True: `byte` ended a packet, whose data are in data() until the next call.
  bool Push(std::uint8_t byte) noexcept;

  const std::uint8_t* data() const noexcept { return data_; }
  std::size_t size() const noexcept { return size_; }
  std::uint32_t cut_short() const noexcept { return cut_short_; }  // packets that ended within a block, wraps
  std::uint32_t too_long() const noexcept { return too_long_; }    // packets of more than kFrameSizeMax, wraps

 private:
  void Begin() noexcept;
  bool End() noexcept;
  void Put(std::uint8_t byte) noexcept;

  std::uint8_t data_[kFrameSizeMax] = {};
  std::size_t size_ = 0;
  std::uint32_t cut_short_ = 0;
  std::uint32_t too_long_ = 0;
  std::uint8_t left_ = 0;      // of the current block
  bool zero_follows_ = false;  // the next block, if there is one, begins with a zero of the data
  bool begun_ = false;         // a byte of the current packet was received
  bool overflow_ = false;
  bool ended_ = false;  // data_ was returned: the next byte begins a new packet
};

}  // namespace omni::wire
