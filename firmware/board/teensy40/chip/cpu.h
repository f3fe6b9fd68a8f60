// The Cortex-M7 itself: interrupts, fault and cache registers. ARM: ARMv7-M Architecture Reference Manual
// (DDI 0403E); its section is named.
#pragma once

#include <cstdint>

#include "firmware/board/teensy40/chip/register_access.h"

namespace omni::board {

inline Reg32& RegisterAt(std::uint32_t address) noexcept { return Block<Reg32>(address); }

// i.MX RT1062 interrupt numbers [RM Interrupts, DMA events and XBAR assignments, CM7 domain interrupts].
enum class Irq : std::uint8_t { kLpi2c1 = 28, kUsb1 = 113, kPit = 122 };
constexpr int kInterrupts = 158;
constexpr int kCoreVectors = 16;
constexpr int kVectors = kCoreVectors + kInterrupts;

// Four priority bits [ARM B1.5.4]; a lower number preempts a higher one.
enum class Priority : std::uint8_t { kHigh = 0x20, kControl = 0x40, kLow = 0x80 };

namespace nvic {  // ARM B3.4
inline void Enable(Irq irq, Priority priority) noexcept {
  const auto number = static_cast<std::uint32_t>(irq);
  Block<Reg8>(0xE000E400 + number) = static_cast<std::uint8_t>(priority);
  RegisterAt(0xE000E100 + 4 * (number / 32)) = 1U << (number % 32);
}
// Triggers it in software.
inline void Pend(Irq irq) noexcept {
  const auto number = static_cast<std::uint32_t>(irq);
  RegisterAt(0xE000E200 + 4 * (number / 32)) = 1U << (number % 32);
}
inline void Disable(Irq irq) noexcept {
  const auto number = static_cast<std::uint32_t>(irq);
  RegisterAt(0xE000E180 + 4 * (number / 32)) = 1U << (number % 32);
  DataBarrier();
  InstructionBarrier();
}
inline void DisableAll() noexcept {
  for (std::uint32_t bank = 0; bank < (kInterrupts + 31) / 32; ++bank) RegisterAt(0xE000E180 + 4 * bank) = 0xFFFFFFFF;
}
}  // namespace nvic

namespace scb {  // ARM B3.2
inline Reg32& VectorTable() noexcept { return RegisterAt(0xE000ED08); }
inline Reg32& ResetControl() noexcept { return RegisterAt(0xE000ED0C); }
inline Reg32& ConfigControl() noexcept { return RegisterAt(0xE000ED14); }
inline Reg32& HandlerControl() noexcept { return RegisterAt(0xE000ED24); }
inline Reg32& CoprocessorAccess() noexcept { return RegisterAt(0xE000ED88); }
inline Reg32& InvalidateInstructionCache() noexcept { return RegisterAt(0xE000EF50); }
constexpr std::uint32_t kResetRequest = 0x05FA0004;      // VECTKEY, SYSRESETREQ
constexpr std::uint32_t kInstructionCacheOn = 1U << 17;  // CCR.IC
constexpr std::uint32_t kFaultHandlersOn = 7U << 16;     // SHCSR: usage, bus and memory faults have their own handlers
constexpr std::uint32_t kFpuFullAccess = 0xFU << 20;     // CPACR: CP10, CP11
}  // namespace scb

namespace mpu {  // ARM B3.5
inline Reg32& Control() noexcept { return RegisterAt(0xE000ED94); }
inline Reg32& RegionBase() noexcept { return RegisterAt(0xE000ED9C); }
inline Reg32& RegionSize() noexcept { return RegisterAt(0xE000EDA0); }
}  // namespace mpu

// Cycle counter, 600 MHz [ARM C1.8].
namespace dwt {
constexpr std::uint32_t kDemcr = 0xE000EDFC, kControl = 0xE0001000, kCycles = 0xE0001004, kLockAccess = 0xE0001FB0;
inline void Start() noexcept {
  RegisterAt(kDemcr) = RegisterAt(kDemcr) | 1U << 24;  // TRCENA
  RegisterAt(kLockAccess) = 0xC5ACCE55;                // locked on the Cortex-M7 until this write
  RegisterAt(kControl) = RegisterAt(kControl) | 1U;    // CYCCNTENA
}
inline std::uint32_t Cycles() noexcept { return RegisterAt(kCycles); }
}  // namespace dwt

// At least that long, at any core clock up to `clock_MHz`; for set-up and for fault handling.
inline void BusyWait(std::uint32_t microseconds, std::uint32_t clock_MHz = 600) noexcept {
  const std::uint32_t begin = dwt::Cycles();
  while (dwt::Cycles() - begin < microseconds * clock_MHz) {
  }
}

// A section without interrupts; nests. For a bus that the control interrupt and the main loop share.
class Critical {
 public:
  Critical() noexcept : before_(InterruptMask()) { InterruptsOff(); }
  ~Critical() { SetInterruptMask(before_); }
  Critical(const Critical&) = delete;
  Critical& operator=(const Critical&) = delete;

 private:
  std::uint32_t before_;
};

}  // namespace omni::board
