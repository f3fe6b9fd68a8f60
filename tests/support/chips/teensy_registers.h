// Stands in for firmware/board/teensy40/chip/register_access.h: registers are memory of the test, and every access to
// one calls a model of the chip.
#pragma once

#include <sys/mman.h>

#include <cstdint>
#include <cstdlib>

namespace omni::support {

// The chip that the board's code sees; one at a time.
class RegisterModel {
 public:
  virtual ~RegisterModel() = default;
  // Value that a read returns, and that a write stores. `held`: value in the register's memory.
  virtual std::uint32_t Read(std::uint32_t address, std::uint32_t held) = 0;
  virtual std::uint32_t Write(std::uint32_t address, std::uint32_t value, std::uint32_t held) = 0;
};
inline RegisterModel* g_register_model = nullptr;

// Peripherals and fast GPIO, and the processor's own registers.
class RegisterSpace {
 public:
  static RegisterSpace& Get() {
    static RegisterSpace space;
    return space;
  }
  void* Place(std::uint32_t address) {
    if (address - kPeripherals < kPeripheralsSize) return peripherals_ + (address - kPeripherals);
    if (address - kCore < kCoreSize) return core_ + (address - kCore);
    std::abort();  // not the address of a register of this chip
  }
  std::uint32_t AddressOf(const void* place) const {
    const auto* byte = static_cast<const std::uint8_t*>(place);
    if (byte >= peripherals_ && byte < peripherals_ + kPeripheralsSize)
      return kPeripherals + static_cast<std::uint32_t>(byte - peripherals_);
    return kCore + static_cast<std::uint32_t>(byte - core_);
  }
  // As after power on.
  void Clear() {
    Drop(peripherals_, kPeripheralsSize);
    Drop(core_, kCoreSize);
  }

 private:
  static constexpr std::uint32_t kPeripherals = 0x40000000, kPeripheralsSize = 0x02010000;
  static constexpr std::uint32_t kCore = 0xE0000000, kCoreSize = 0x00100000;

  static std::uint8_t* Map(std::size_t size) {
    void* memory = ::mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) std::abort();
    return static_cast<std::uint8_t*>(memory);
  }
  static void Drop(std::uint8_t* memory, std::size_t size) { ::madvise(memory, size, MADV_DONTNEED); }

  std::uint8_t* peripherals_ = Map(kPeripheralsSize);
  std::uint8_t* core_ = Map(kCoreSize);
};

}  // namespace omni::support

namespace omni::board {

template <class T>
class ModelRegister {
 public:
  operator T() const {  // NOLINT: reads like the integer it stands for
    return static_cast<T>(support::g_register_model->Read(Address(), value_));
  }
  ModelRegister& operator=(T value) {
    value_ = static_cast<T>(support::g_register_model->Write(Address(), value, value_));
    return *this;
  }
  ModelRegister& operator=(const ModelRegister& other) { return *this = static_cast<T>(other); }
  ModelRegister& operator|=(T bits) { return *this = static_cast<T>(*this | bits); }
  ModelRegister& operator&=(T bits) { return *this = static_cast<T>(*this & bits); }

 private:
  std::uint32_t Address() const { return support::RegisterSpace::Get().AddressOf(this); }
  T value_;
};

using Reg8 = ModelRegister<std::uint8_t>;
using Reg16 = ModelRegister<std::uint16_t>;
using Reg32 = ModelRegister<std::uint32_t>;
static_assert(sizeof(Reg16) == 2 && sizeof(Reg32) == 4, "the chip's layout");

template <class T>
inline T& Block(std::uint32_t address) noexcept {
  return *static_cast<T*>(support::RegisterSpace::Get().Place(address));
}

inline void DataBarrier() noexcept {}
inline void InstructionBarrier() noexcept {}
inline void InterruptsOff() noexcept {}
inline void InterruptsOn() noexcept {}
inline void WaitForInterrupt() noexcept {}
inline std::uint32_t InterruptMask() noexcept { return 0; }
inline void SetInterruptMask(std::uint32_t) noexcept {}

}  // namespace omni::board
