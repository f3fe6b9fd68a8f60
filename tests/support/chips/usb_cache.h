// Memory as seen by processor and USB controller with a write-back cache between them: two copies, and lines of 32
// bytes that are transferred only by cleaning and invalidating, or spontaneously by the cache.
#pragma once

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <random>
#include <string>
#include <vector>

namespace omni::support {

class UsbCache {
 public:
  static constexpr std::size_t kLine = 32;
  static constexpr std::uint32_t kBase = 0x20208000;  // where the controller finds the first byte

  // The controller's copy starts as garbage, every line of the processor's is dirty.
  UsbCache(void* memory, std::size_t size)
      : cpu_(static_cast<std::uint8_t*>(memory)), device_(size, 0xA5), synced_(size), dirty_(size / kLine, true) {
    std::memcpy(synced_.data(), cpu_, size);
  }

  std::uint32_t Address(const volatile void* memory) {
    const auto offset = static_cast<std::size_t>(static_cast<const volatile std::uint8_t*>(memory) - cpu_);
    if (offset >= device_.size()) Complain("address outside of the shared memory");
    return kBase + static_cast<std::uint32_t>(offset);
  }

  void Clean(const volatile void* memory, std::size_t size) {
    for (std::size_t line = First(memory, size), count = size / kLine; count > 0; ++line, --count) WriteBack(line);
  }

  void Invalidate(const volatile void* memory, std::size_t size) {
    for (std::size_t line = First(memory, size), count = size / kLine; count > 0; ++line, --count) {
      if (IsDirty(line)) Complain("a line with our writes is invalidated");
      Fetch(line);
    }
  }

  // Any dirty line may be written back and any clean one fetched again at any time.
  void Stir(std::mt19937& random) {
    for (int i = 0; i < 8; ++i) {
      const std::size_t line = random() % dirty_.size();
      IsDirty(line) ? WriteBack(line) : Fetch(line);
    }
  }

  // The controller's side.
  std::uint32_t Load(std::uint32_t address) {
    std::uint32_t value = 0;
    if (InRange(address, 4)) std::memcpy(&value, device_.data() + (address - kBase), 4);
    return value;
  }
  void Store(std::uint32_t address, std::uint32_t value) {
    if (InRange(address, 4)) std::memcpy(device_.data() + (address - kBase), &value, 4);
  }
  std::uint8_t LoadByte(std::uint32_t address) { return InRange(address, 1) ? device_[address - kBase] : 0; }
  void StoreByte(std::uint32_t address, std::uint8_t value) {
    if (InRange(address, 1)) device_[address - kBase] = value;
  }

  void Complain(const std::string& what) { complaints.push_back(what); }
  std::vector<std::string> complaints;  // violations by the driver

 private:
  std::size_t First(const volatile void* memory, std::size_t size) {
    const std::size_t offset = Address(memory) - kBase;
    if (offset % kLine != 0 || size % kLine != 0) Complain("cache maintenance of parts of a line");
    if (offset + size > device_.size()) Complain("cache maintenance outside of the shared memory");
    return offset / kLine;
  }

  bool InRange(std::uint32_t address, std::size_t size) {
    const bool in_range = address >= kBase && address - kBase + size <= device_.size();
    if (!in_range) Complain("the controller is sent outside of the shared memory");
    return in_range;
  }

  bool IsDirty(std::size_t line) const {
    return dirty_[line] || std::memcmp(cpu_ + line * kLine, synced_.data() + line * kLine, kLine) != 0;
  }

  // Also a line that looks clean: it may have been written with the values that it had, while the controller has
  // changed its copy.
  void WriteBack(std::size_t line) {
    std::memcpy(device_.data() + line * kLine, cpu_ + line * kLine, kLine);
    std::memcpy(synced_.data() + line * kLine, cpu_ + line * kLine, kLine);
    dirty_[line] = false;
  }

  void Fetch(std::size_t line) {
    std::memcpy(cpu_ + line * kLine, device_.data() + line * kLine, kLine);
    std::memcpy(synced_.data() + line * kLine, cpu_ + line * kLine, kLine);
    dirty_[line] = false;
  }

  std::uint8_t* cpu_;
  std::vector<std::uint8_t> device_;
  std::vector<std::uint8_t> synced_;  // of the processor's lines, when last transferred
  std::vector<bool> dirty_;
};

}  // namespace omni::support
