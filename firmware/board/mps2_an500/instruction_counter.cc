#include "firmware/board/mps2_an500/instruction_counter.h"

namespace omni::firmware::board {
namespace {

volatile std::uint32_t& Register(std::uintptr_t address) noexcept {
  return *reinterpret_cast<volatile std::uint32_t*>(address);
}
constexpr std::uintptr_t kControl = 0xE000E010;
constexpr std::uintptr_t kReload = 0xE000E014;
constexpr std::uintptr_t kCurrent = 0xE000E018;
constexpr std::uint32_t kEnableProcessorClock = 1U | (1U << 2);
constexpr std::uint32_t kTicksMax = 0xFFFFFFU;

}  // namespace

InstructionCounter::InstructionCounter() noexcept {
  Register(kReload) = kTicksMax;
  Register(kCurrent) = 0;
  Register(kControl) = kEnableProcessorClock;
  Begin();
  ticks_of_nothing_ = Elapsed();
  Begin();
  __asm__ volatile(".rept 1024\n nop\n .endr");
  ticks_of_1024_ = Elapsed() - ticks_of_nothing_;
}

void InstructionCounter::Begin() noexcept { begin_ = Register(kCurrent); }

std::uint32_t InstructionCounter::End() const noexcept {
  const std::uint32_t elapsed = Elapsed();
  if (ticks_of_1024_ == 0 || elapsed < ticks_of_nothing_) return 0;
  const std::uint64_t ticks = elapsed - ticks_of_nothing_;
  return static_cast<std::uint32_t>((ticks * 1024 + ticks_of_1024_ / 2) / ticks_of_1024_);
}

// It counts down, and wraps.
std::uint32_t InstructionCounter::Elapsed() const noexcept { return (begin_ - Register(kCurrent)) & kTicksMax; }

}  // namespace omni::firmware::board
