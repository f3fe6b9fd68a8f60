#include "firmware/board/teensy40/chip/chip.h"

#include "firmware/board/teensy40/boot/retained.h"
#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {

firmware::Settings ChipSettings() noexcept {
  constexpr char kPrefix[] = {'o', 'm', 'n', 'i', '-'};
  constexpr char kDigits[] = "0123456789abcdef";
  constexpr int kNumberDigits = 10;
  firmware::Settings settings;
  static_assert(sizeof settings.serial == sizeof kPrefix + kNumberDigits + 1, "text and its end");
  const std::uint64_t number = std::uint64_t{Word(kFuseUnique1)} << 32 | Word(kFuseUnique0);
  char* text = settings.serial;
  for (const char letter : kPrefix) *text++ = letter;
  for (int i = kNumberDigits - 1; i >= 0; --i) *text++ = kDigits[number >> (4 * i) & 0xF];
  *text = 0;
  return settings;
}

firmware::ResetCause PopResetCause(bool crashed) noexcept {
  const std::uint32_t status = Word(kResetStatus);
  Word(kResetStatus) = status;
  if (crashed || (status & kResetByWatchdogs) != 0) return firmware::ResetCause::kWatchdog;
  return (status & kResetBySoftware) != 0 ? firmware::ResetCause::kSoftware : firmware::ResetCause::kPower;
}

}  // namespace omni::board
