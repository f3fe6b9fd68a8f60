// Memory shared with the USB controller: queue heads (dQH), transfer descriptors (dTD) and packet buffers
// [NXP IMXRT1060RM, USB: "Device Data Structures"]. All of it is one block, so that one MPU region and one address map
// are enough. It may lie in cached memory: structures fill whole lines of 32 bytes.
#pragma once

#include <cstddef>
#include <cstdint>

namespace omni::drivers::usb {

constexpr std::size_t kCacheLine = 32;
constexpr std::uint32_t kTerminate = 1;  // in place of an address: the list ends

// Token of a dTD and of the overlay in a dQH.
constexpr std::uint32_t kTokenActive = 1U << 7;
constexpr std::uint32_t kTokenHalted = 1U << 6;
constexpr std::uint32_t kTokenBufferError = 1U << 5;
constexpr std::uint32_t kTokenTransactionError = 1U << 3;
constexpr std::uint32_t kTokenErrors = kTokenHalted | kTokenBufferError | kTokenTransactionError;
constexpr std::uint32_t kTokenInterrupt = 1U << 15;  // IOC
constexpr int kTokenBytesShift = 16;                 // total bytes, 15 bits: counts down
constexpr std::uint32_t kTokenBytesMask = 0x7FFF;

// No initial values: this may be in memory that start-up does not touch; the driver initialises what it uses.
struct alignas(32) TransferDescriptor {
  volatile std::uint32_t next;
  volatile std::uint32_t token;
  volatile std::uint32_t page[5];
  std::uint32_t reserved;
};
static_assert(sizeof(TransferDescriptor) == kCacheLine, "fills its cache line");

// Capabilities of a dQH.
constexpr int kPacketSizeShift = 16;
constexpr std::uint32_t kInterruptOnSetup = 1U << 15;
// ZLT: set, no empty packet ends a transfer that is a multiple of the packet size.
constexpr std::uint32_t kNoZeroLengthEnd = 1U << 29;

struct alignas(64) QueueHead {
  // First line: written by us while the endpoint is not primed.
  volatile std::uint32_t capabilities;
  volatile std::uint32_t current;
  volatile std::uint32_t next;
  volatile std::uint32_t token;
  volatile std::uint32_t page[4];
  // Second line: the controller's, we only read `setup`.
  volatile std::uint32_t page4;
  std::uint32_t reserved;
  volatile std::uint32_t setup[2];
  std::uint32_t padding[4];
};
static_assert(sizeof(QueueHead) == 64 && offsetof(QueueHead, setup) == 40, "layout of the controller");

// Queue heads stand in the order of the controller: OUT and IN of endpoint 0, OUT and IN of endpoint 1.
constexpr int kControlOut = 0, kControlIn = 1, kBulkOut = 2, kBulkIn = 3;
constexpr int kQueueHeads = 4;

constexpr std::size_t kBufferSize = 512;
constexpr int kReceiveDepth = 4;  // whole transfers kept until they are read; full: the host has to wait (NAK)
constexpr int kSendDepth = 4;     // frames that wait for the host; full: Send drops the oldest

struct alignas(2048) UsbMemory {
  QueueHead queues[kQueueHeads];
  TransferDescriptor control_in[2];  // data and, if needed, the empty packet that ends them
  TransferDescriptor control_out;
  TransferDescriptor bulk_out;
  TransferDescriptor bulk_in;
  alignas(kBufferSize) std::uint8_t control[kBufferSize];
  std::uint8_t receive[kReceiveDepth][kBufferSize];
  std::uint8_t send[kSendDepth][kBufferSize];
};
static_assert(sizeof(UsbMemory) % kCacheLine == 0, "nothing else in its cache lines");

// A queue of packet buffers: `order` lists the slots, the first `count` of them hold transfers (oldest first), the
// one after is filled next.
template <int kDepth>
class SlotQueue {
 public:
  SlotQueue() noexcept { Clear(); }

  void Clear() noexcept {
    for (int i = 0; i < kDepth; ++i) order_[i] = static_cast<std::uint8_t>(i);
    count_ = 0;
  }

  int count() const noexcept { return count_; }
  bool full() const noexcept { return count_ == kDepth; }
  int front() const noexcept { return order_[0]; }
  // Only while not full. Removing an older one does not change which slot this is.
  int next() const noexcept { return order_[count_]; }
  std::size_t size(int slot) const noexcept { return size_[slot]; }

  void Push(std::size_t size) noexcept {
    size_[next()] = static_cast<std::uint16_t>(size);
    ++count_;
  }

  // 0: the oldest.
  void Remove(int position) noexcept {
    const std::uint8_t slot = order_[position];
    for (int i = position; i + 1 < kDepth; ++i) order_[i] = order_[i + 1];
    order_[kDepth - 1] = slot;
    --count_;
  }

 private:
  std::uint8_t order_[kDepth] = {};
  std::uint16_t size_[kDepth] = {};
  int count_ = 0;
};

}  // namespace omni::drivers::usb
