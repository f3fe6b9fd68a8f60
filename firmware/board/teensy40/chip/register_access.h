// Access to registers: on the chip, at their addresses. A build that defines OMNI_REGISTER_MODEL, the name of a header,
// replaces that: tests run the board's code on a model of the chip.
#pragma once

#include <cstdint>

#ifdef OMNI_REGISTER_MODEL
#include OMNI_REGISTER_MODEL
#else

namespace omni::board {

using Reg8 = volatile std::uint8_t;
using Reg16 = volatile std::uint16_t;
using Reg32 = volatile std::uint32_t;

// T: a register, or a struct of registers.
template <class T>
inline T& Block(std::uint32_t address) noexcept {
  return *reinterpret_cast<T*>(address);
}

inline void DataBarrier() noexcept { asm volatile("dsb" ::: "memory"); }
inline void InstructionBarrier() noexcept { asm volatile("isb" ::: "memory"); }
inline void InterruptsOff() noexcept { asm volatile("cpsid i" ::: "memory"); }
inline void InterruptsOn() noexcept { asm volatile("cpsie i" ::: "memory"); }
inline void WaitForInterrupt() noexcept { asm volatile("wfi" ::: "memory"); }

inline std::uint32_t InterruptMask() noexcept {
  std::uint32_t mask;
  asm volatile("mrs %0, primask" : "=r"(mask));
  return mask;
}
inline void SetInterruptMask(std::uint32_t mask) noexcept { asm volatile("msr primask, %0" ::"r"(mask) : "memory"); }

}  // namespace omni::board

#endif
