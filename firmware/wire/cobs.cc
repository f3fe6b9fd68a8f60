#include "firmware/wire/cobs.h"

namespace omni::wire {
namespace {

constexpr std::uint8_t kFullBlock = kCobsBlockMax + 1;

class CobsWriter {
 public:
  CobsWriter(std::uint8_t* packet, std::size_t capacity) noexcept : packet_(packet), capacity_(capacity) {}

  void OpenBlock() noexcept {
    code_at_ = size_;
    Append(1);
  }
  // Precondition: not 0, and the block is not full.
  void Put(std::uint8_t byte) noexcept {
    Append(byte);
    if (ok_) ++packet_[code_at_];
  }
  bool block_full() const noexcept { return ok_ && packet_[code_at_] == kFullBlock; }
  std::size_t size() const noexcept { return ok_ ? size_ : 0; }

 private:
  void Append(std::uint8_t byte) noexcept {
    ok_ = ok_ && size_ < capacity_;
    if (ok_) packet_[size_++] = byte;
  }

  std::uint8_t* packet_;
  std::size_t capacity_;
  std::size_t size_ = 0;
  std::size_t code_at_ = 0;
  bool ok_ = true;
};

}  // namespace

std::size_t CobsEncode(const std::uint8_t* data, std::size_t size, std::uint8_t* packet,
                       std::size_t capacity) noexcept {
  CobsWriter out(packet, capacity);
  out.OpenBlock();
  for (std::size_t i = 0; i < size; ++i) {
    if (out.block_full()) out.OpenBlock();  // only now: after the last data it would waste a byte
    if (data[i] == 0) {
      out.OpenBlock();
    } else {
      out.Put(data[i]);
    }
  }
  return out.size();
}

void CobsReceiver::Begin() noexcept {
  size_ = 0;
  left_ = 0;
  zero_follows_ = begun_ = overflow_ = ended_ = false;
}

bool CobsReceiver::End() noexcept {
  const bool whole = begun_ && left_ == 0 && !overflow_;
  if (begun_ && overflow_) ++too_long_;
  if (begun_ && !overflow_ && left_ != 0) ++cut_short_;
  if (whole) {
    ended_ = true;
  } else {
    Begin();
  }
  return whole;
}

void CobsReceiver::Put(std::uint8_t byte) noexcept {
  if (size_ == kFrameSizeMax) {
    overflow_ = true;
  } else {
    data_[size_++] = byte;
  }
}

bool CobsReceiver::Push(std::uint8_t byte) noexcept {
  if (ended_) Begin();
  if (byte == kCobsEnd) return End();
  if (left_ != 0) {
    Put(byte);
    --left_;
    return false;
  }
  if (zero_follows_) Put(0);
  begun_ = true;
  left_ = static_cast<std::uint8_t>(byte - 1);
  zero_follows_ = byte != kFullBlock;
  return false;
}

}  // namespace omni::wire
