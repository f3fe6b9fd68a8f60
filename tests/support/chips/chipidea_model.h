// The ChipIdea USB controller in device mode for tests: registers on one side, tokens of a host on the other, queue
// heads and transfer descriptors in (cached) memory between them [NXP IMXRT1060RM, USB]. Written from the manual,
// independently of the driver: bits are defined again here. Violations by the driver are listed in complaints().
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/chips/usb_cache.h"

namespace omni::support {

class ChipideaModel {
 public:
  enum class Answer { kNothing, kAck, kNak, kStall };
  struct Packet {
    Answer answer = Answer::kNothing;
    int toggle = 0;
    std::vector<std::uint8_t> data;
  };

  ChipideaModel(void* memory, std::size_t size, unsigned seed = 1) : cache_(memory, size), random_(seed) {}

  // ---- the driver's side (its bus policy)
  std::uint32_t Read(std::uint32_t offset) noexcept;
  void Write(std::uint32_t offset, std::uint32_t value) noexcept;
  std::uint32_t Address(const volatile void* memory) noexcept { return cache_.Address(memory); }
  void CleanCache(const volatile void* memory, std::size_t size) noexcept { cache_.Clean(memory, size); }
  void InvalidateCache(const volatile void* memory, std::size_t size) noexcept;
  bool InterruptPending() const { return (sts_ & intr_) != 0 || ((otgsc_ >> 19) & (otgsc_ >> 27) & 1) != 0; }

  // ---- the host's side
  Answer Setup(int address, const std::array<std::uint8_t, 8>& bytes);
  Packet In(int address, int endpoint);
  Answer Out(int address, int endpoint, int toggle, const std::vector<std::uint8_t>& data);
  void BeginReset();
  void EndReset(bool high_speed);
  void Suspend();
  void Resume();
  void Unplug();
  void Plug();
  // The next packet at this endpoint arrives damaged three times: the transfer ends with an error.
  void DamageNext(int endpoint, bool in) { damage_ |= Bit(endpoint, in); }

  bool running() const { return (cmd_ & 1) != 0; }
  const std::vector<std::string>& complaints() const { return cache_.complaints; }
  // SETUPs that arrive at the worst moment: while the driver copies the one before, and while it primes endpoint 0.
  std::function<void()> while_copying, while_priming;
  // Caches that write back and fetch spontaneously, at any access to a register.
  bool stir = false;
  // ENDPTFLUSH and the controller's reset never end.
  bool stuck = false;

 private:
  static std::uint32_t Bit(int endpoint, bool in) { return 1U << (endpoint + (in ? 16 : 0)); }
  std::uint32_t Head(int endpoint, bool in) const { return list_ + 64U * static_cast<unsigned>(2 * endpoint + in); }

  void Later(bool now = false);
  void Prime(int endpoint, bool in);
  bool LoadTransfer(int endpoint, bool in, std::uint32_t transfer);
  void Retire(int endpoint, bool in, std::uint32_t token);
  void ResetController();
  bool Reaches(int address, int endpoint, bool in);
  std::uint32_t BufferAddress(std::uint32_t head, std::uint32_t at);

  UsbCache cache_;
  std::mt19937 random_;
  std::uint32_t cmd_ = 0x00080000, sts_ = 0, intr_ = 0, list_ = 0, portsc_ = 0, otgsc_ = 1U << 11, mode_ = 0;
  std::uint32_t setupstat_ = 0, prime_ = 0, flush_ = 0, stat_ = 0, complete_ = 0;
  std::array<std::uint32_t, 8> ctrl_{};
  std::array<std::array<int, 2>, 8> toggle_{};
  std::array<std::array<std::uint32_t, 2>, 8> done_{};  // bytes of the transfer so far
  int address_ = 0, staged_address_ = -1, delay_ = 0;
  std::uint32_t damage_ = 0;
};

inline void ChipideaModel::ResetController() {
  cmd_ = 0x00080000;
  sts_ = intr_ = list_ = portsc_ = mode_ = setupstat_ = prime_ = flush_ = stat_ = complete_ = 0;
  ctrl_.fill(0);
  address_ = 0;
  staged_address_ = -1;
}

inline std::uint32_t ChipideaModel::Read(std::uint32_t offset) noexcept {
  if (stir) cache_.Stir(random_);
  Later();
  switch (offset) {
    case 0x140:
      return cmd_;
    case 0x144:
      return sts_;
    case 0x148:
      return intr_;
    case 0x184:
      return portsc_;
    case 0x1A4:
      return otgsc_;
    case 0x1A8:
      return mode_;
    case 0x1AC:
      return setupstat_;
    case 0x1B0:
      return prime_;
    case 0x1B4:
      return flush_;
    case 0x1B8:
      return stat_;
    case 0x1BC:
      return complete_;
    default:
      break;
  }
  if (offset >= 0x1C0 && offset < 0x1E0) return ctrl_[(offset - 0x1C0) / 4];
  cache_.Complain("reads a register that does not exist");
  return 0;
}

inline void ChipideaModel::Write(std::uint32_t offset, std::uint32_t value) noexcept {
  if (stir) cache_.Stir(random_);
  switch (offset) {
    case 0x140:
      if ((value & 2) != 0) {
        ResetController();
        if (stuck) cmd_ |= 2;
        return;
      }
      if ((value & 1) != 0 && (mode_ & 3) != 2) cache_.Complain("runs without device mode");
      cmd_ = value;
      return;
    case 0x144:
      sts_ &= ~value;
      return;
    case 0x148:
      intr_ = value;
      return;
    case 0x154:
      staged_address_ = -1;
      if ((value & (1U << 24)) != 0) {
        staged_address_ = static_cast<int>(value >> 25);
      } else {
        address_ = static_cast<int>(value >> 25);
      }
      return;
    case 0x158:
      if (value % 2048 != 0) cache_.Complain("list of queue heads not on 2 KB");
      list_ = value;
      return;
    case 0x1A4:
      otgsc_ = (otgsc_ & 0x007F0800U & ~(value & 0x007F0000U)) | (value & 0x7F000000U);
      return;
    case 0x1A8:
      mode_ = value;
      return;
    case 0x1AC:
      setupstat_ &= ~value;
      return;
    case 0x1B0:
      prime_ |= value;
      delay_ = static_cast<int>(random_() % 4);
      if ((value & 0x00010001U) != 0 && while_priming) std::exchange(while_priming, nullptr)();
      return;
    case 0x1B4:
      flush_ |= value;
      delay_ = static_cast<int>(random_() % 4);
      return;
    case 0x1BC:
      complete_ &= ~value;
      return;
    default:
      break;
  }
  if (offset < 0x1C0 || offset >= 0x1E0) return cache_.Complain("writes a register that does not exist");
  const auto endpoint = static_cast<std::size_t>((offset - 0x1C0) / 4);
  if ((value & (1U << 6)) != 0) toggle_[endpoint][0] = 0;
  if ((value & (1U << 22)) != 0) toggle_[endpoint][1] = 0;
  ctrl_[endpoint] = value & ~((1U << 6) | (1U << 22));
}

inline void ChipideaModel::InvalidateCache(const volatile void* memory, std::size_t size) noexcept {
  cache_.Invalidate(memory, size);
  const std::uint32_t setup = list_ + 32;
  if (list_ != 0 && Address(memory) == setup && while_copying) std::exchange(while_copying, nullptr)();
}

// Actions of the controller a few accesses after they were requested.
inline void ChipideaModel::Later(bool now) {
  if (stuck) return;
  if (!now && delay_-- > 0) return;
  stat_ &= ~flush_;
  flush_ = 0;
  for (int endpoint = 0; endpoint < 8; ++endpoint) {
    for (const bool in : {false, true}) {
      if ((prime_ & Bit(endpoint, in)) != 0) Prime(endpoint, in);
    }
  }
}

inline void ChipideaModel::Prime(int endpoint, bool in) {
  const std::uint32_t bit = Bit(endpoint, in);
  prime_ &= ~bit;
  if (endpoint == 0 && (setupstat_ & 1) != 0) return;  // locked out: a SETUP waits
  if (endpoint != 0 && ((ctrl_[static_cast<std::size_t>(endpoint)] >> (in ? 16 : 0)) & 0x80) == 0) {
    return cache_.Complain("primes an endpoint that is not enabled");
  }
  if ((stat_ & bit) != 0) return cache_.Complain("primes an endpoint that is primed");
  const std::uint32_t next = cache_.Load(Head(endpoint, in) + 8);
  if ((next & 1) == 0 && LoadTransfer(endpoint, in, next)) stat_ |= bit;
}

inline bool ChipideaModel::LoadTransfer(int endpoint, bool in, std::uint32_t transfer) {
  if (transfer % 32 != 0) cache_.Complain("transfer descriptor not on 32 bytes");
  const std::uint32_t head = Head(endpoint, in);
  if ((cache_.Load(transfer + 4) & 0x80) == 0) return false;
  if ((cache_.Load(head + 12) & 0xC0) != 0) cache_.Complain("primes over an active or halted overlay");
  cache_.Store(head + 4, transfer);
  for (std::uint32_t i = 0; i < 28; i += 4) cache_.Store(head + 8 + i, cache_.Load(transfer + i));
  done_[static_cast<std::size_t>(endpoint)][in] = 0;
  return true;
}

inline void ChipideaModel::Retire(int endpoint, bool in, std::uint32_t token) {
  const std::uint32_t head = Head(endpoint, in);
  token &= ~0x80U;
  cache_.Store(head + 12, token);
  cache_.Store(cache_.Load(head + 4) + 4, token);
  stat_ &= ~Bit(endpoint, in);
  complete_ |= Bit(endpoint, in);
  if ((token & (1U << 15)) != 0) sts_ |= 1;
  const std::uint32_t next = cache_.Load(head + 8);
  if ((token & 0x68) == 0 && (next & 1) == 0 && LoadTransfer(endpoint, in, next)) stat_ |= Bit(endpoint, in);
}

inline std::uint32_t ChipideaModel::BufferAddress(std::uint32_t head, std::uint32_t at) {
  const std::uint32_t first = cache_.Load(head + 16);
  const std::uint32_t offset = (first & 0xFFF) + at;
  return (cache_.Load(head + 16 + 4 * (offset >> 12)) & ~0xFFFU) + (offset & 0xFFF);
}

inline bool ChipideaModel::Reaches(int address, int endpoint, bool in) {
  Later(true);
  if (!running() || (otgsc_ & (1U << 11)) == 0 || (portsc_ & 0x180) != 0 || address != address_) return false;
  return endpoint == 0 || ((ctrl_[static_cast<std::size_t>(endpoint)] >> (in ? 16 : 0)) & 0x80) != 0;
}

inline ChipideaModel::Answer ChipideaModel::Setup(int address, const std::array<std::uint8_t, 8>& bytes) {
  if (!Reaches(address, 0, false)) return Answer::kNothing;
  for (std::uint32_t i = 0; i < 8; ++i) cache_.StoreByte(Head(0, false) + 40 + i, bytes[i]);
  setupstat_ |= 1;
  cmd_ &= ~(1U << 13);
  ctrl_[0] &= ~0x00010001U;
  stat_ &= ~0x00010001U;
  prime_ &= ~0x00010001U;
  toggle_[0] = {1, 1};
  staged_address_ = -1;
  if ((cache_.Load(Head(0, false)) & (1U << 15)) != 0) sts_ |= 1;
  return Answer::kAck;
}

inline ChipideaModel::Packet ChipideaModel::In(int address, int endpoint) {
  Packet packet;
  if (!Reaches(address, endpoint, true)) return packet;
  const auto e = static_cast<std::size_t>(endpoint);
  packet.answer = (ctrl_[e] & (1U << 16)) != 0 ? Answer::kStall : Answer::kNak;
  if (packet.answer == Answer::kStall || (stat_ & Bit(endpoint, true)) == 0) return packet;
  const std::uint32_t head = Head(endpoint, true);
  const std::uint32_t capabilities = cache_.Load(head);
  const std::uint32_t size_max = (capabilities >> 16) & 0x7FF;
  std::uint32_t token = cache_.Load(head + 12);
  if ((damage_ & Bit(endpoint, true)) != 0) {
    damage_ &= ~Bit(endpoint, true);
    Retire(endpoint, true, token | 0x08);
    sts_ |= 2;
    packet.answer = Answer::kNothing;
    return packet;
  }
  const std::uint32_t left = (token >> 16) & 0x7FFF;
  const std::uint32_t size = left < size_max ? left : size_max;
  for (std::uint32_t i = 0; i < size; ++i) packet.data.push_back(cache_.LoadByte(BufferAddress(head, done_[e][1] + i)));
  packet.answer = Answer::kAck;
  packet.toggle = std::exchange(toggle_[e][1], 1 - toggle_[e][1]);
  done_[e][1] += size;
  token -= size << 16;
  cache_.Store(head + 12, token);
  // A transfer that fills its last packet ends with an empty one, unless configured otherwise.
  const bool more = left > size || (size == size_max && (capabilities & (1U << 29)) == 0);
  if (!more) Retire(endpoint, true, token);
  if (endpoint == 0 && staged_address_ >= 0) address_ = std::exchange(staged_address_, -1);
  return packet;
}

inline ChipideaModel::Answer ChipideaModel::Out(int address, int endpoint, int toggle,
                                                const std::vector<std::uint8_t>& data) {
  if (!Reaches(address, endpoint, false)) return Answer::kNothing;
  const auto e = static_cast<std::size_t>(endpoint);
  if (endpoint == 0) staged_address_ = -1;
  if ((ctrl_[e] & 1) != 0) return Answer::kStall;
  if ((stat_ & Bit(endpoint, false)) == 0) return Answer::kNak;
  if (toggle != toggle_[e][0]) return Answer::kAck;  // a repetition: acknowledged and discarded
  const std::uint32_t head = Head(endpoint, false);
  std::uint32_t token = cache_.Load(head + 12);
  const std::uint32_t left = (token >> 16) & 0x7FFF;
  const std::uint32_t size_max = (cache_.Load(head) >> 16) & 0x7FF;
  const auto size = static_cast<std::uint32_t>(data.size());
  if (size > size_max || size > left || (damage_ & Bit(endpoint, false)) != 0) {
    damage_ &= ~Bit(endpoint, false);
    Retire(endpoint, false, token | 0x08);
    sts_ |= 2;
    return Answer::kNothing;
  }
  for (std::uint32_t i = 0; i < size; ++i) cache_.StoreByte(BufferAddress(head, done_[e][0] + i), data[i]);
  toggle_[e][0] = 1 - toggle_[e][0];
  done_[e][0] += size;
  token -= size << 16;
  cache_.Store(head + 12, token);
  if (size < size_max || size == left) Retire(endpoint, false, token);
  return Answer::kAck;
}

inline void ChipideaModel::BeginReset() {
  if (!running()) return;
  address_ = 0;
  staged_address_ = -1;
  stat_ = prime_ = damage_ = 0;
  portsc_ = (portsc_ & ~0x80U) | 0x100;
  sts_ |= 1U << 6;
}

inline void ChipideaModel::EndReset(bool high_speed) {
  portsc_ = high_speed ? 0x200 : 0;
  if (running()) sts_ |= 1U << 2;
}

inline void ChipideaModel::Suspend() {
  if (!running()) return;
  portsc_ |= 0x80;
  sts_ |= 1U << 8;
}

inline void ChipideaModel::Resume() {
  if (!running() || (portsc_ & 0x80) == 0) return;
  portsc_ &= ~0x80U;
  sts_ |= 1U << 2;
}

inline void ChipideaModel::Unplug() {
  otgsc_ = (otgsc_ & ~(1U << 11)) | (1U << 19);
  address_ = 0;
}

inline void ChipideaModel::Plug() { otgsc_ |= (1U << 11) | (1U << 19); }

}  // namespace omni::support
