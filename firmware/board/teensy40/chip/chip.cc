#include "firmware/board/teensy40/chip/chip.h"

#include "firmware/board/teensy40/boot/retained.h"
#include "firmware/board/teensy40/chip/cpu.h"
#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {
namespace {

constexpr std::int32_t kRoom_C = 25;  // the first point of the factory's calibration; the second is in the fuses
constexpr std::uint32_t kMeasureEvery = 0x100;  // ticks of 32.768 kHz: 8 ms

constexpr std::uint32_t kUnlock = 0xD928C520, kRefresh = 0xB480A602;
constexpr std::uint32_t kInWait = 1U << 1, kUpdate = 1U << 5, kOn = 1U << 7, kLowPowerClock = 1U << 8;
constexpr std::uint32_t kReconfigured = 1U << 10, kUnlocked = 1U << 11, kCommand32 = 1U << 13;
constexpr std::uint32_t kLowPowerClock_Hz = 32'768;
constexpr std::uint32_t kTimeoutTicks =
    static_cast<std::uint32_t>(std::uint64_t{kWatchdogTimeout_us} * kLowPowerClock_Hz / 1'000'000);
static_assert(kTimeoutTicks > 100 && kTimeoutTicks < 0x10000, "16 bits");

// New settings are accepted only within 128 bus clocks of the unlocking, so nothing may come between.
void Configure(std::uint32_t control, std::uint32_t ticks) noexcept {
  const Critical critical;
  RtWatchdog& dog = wdog3();
  if ((dog.CS & kCommand32) != 0) {
    dog.CNT = kUnlock;
  } else {
    dog.CNT = kUnlock & 0xFFFF;
    dog.CNT = kUnlock >> 16;
  }
  while ((dog.CS & kUnlocked) == 0) {
  }
  dog.TOVAL = ticks;
  dog.WIN = 0;
  dog.CS = control;
  while ((dog.CS & kReconfigured) == 0) {
  }
}

}  // namespace

firmware::Settings ChipSettings() noexcept {
  constexpr char kPrefix[] = {'o', 'm', 'n', 'i', '-'};
  constexpr char kDigits[] = "0123456789abcdef";
  constexpr int kNumberDigits = 10;
  firmware::Settings settings;
  static_assert(sizeof settings.serial == sizeof kPrefix + kNumberDigits + 1, "text and its end");
  const std::uint64_t number = std::uint64_t{RegisterAt(kFuseUnique1)} << 32 | RegisterAt(kFuseUnique0);
  char* text = settings.serial;
  for (const char letter : kPrefix) *text++ = letter;
  for (int i = kNumberDigits - 1; i >= 0; --i) *text++ = kDigits[number >> (4 * i) & 0xF];
  *text = 0;
  return settings;
}

firmware::ResetCause PopResetCause(bool crashed) noexcept {
  const std::uint32_t status = RegisterAt(kResetStatus);
  RegisterAt(kResetStatus) = status;
  if (crashed || (status & kResetByWatchdogs) != 0) return firmware::ResetCause::kWatchdog;
  return (status & kResetBySoftware) != 0 ? firmware::ResetCause::kSoftware : firmware::ResetCause::kPower;
}

void Thermometer::Start() noexcept {
  const std::uint32_t fuse = RegisterAt(kFuseThermometer);
  room_count_ = static_cast<std::int32_t>(fuse >> 20);
  hot_count_ = static_cast<std::int32_t>(fuse >> 8 & 0xFFF);
  hot_C_ = static_cast<std::int32_t>(fuse & 0xFF);
  analog().TEMPSENSE0.clear = analog_bits::kTempPowerDown;
  analog().TEMPSENSE1.value = kMeasureEvery;
  analog().TEMPSENSE0.set = analog_bits::kTempMeasure;
}

// T = hot - (count - hot_count) (hot - 25) / (room_count - hot_count)   [RM TEMPMON, temperature equation]
std::int16_t Thermometer::Read() noexcept {
  const std::uint32_t value = analog().TEMPSENSE0.value;
  const std::int32_t span = room_count_ - hot_count_;
  if ((value & analog_bits::kTempFinished) == 0 || span <= 0) return last_;
  const auto count = static_cast<std::int32_t>(value >> 8 & 0xFFF);
  last_ = static_cast<std::int16_t>(100 * hot_C_ - 100 * (count - hot_count_) * (hot_C_ - kRoom_C) / span);
  return last_;
}

void StopWatchdogOfRom() noexcept {
  if ((wdog3().CS & kOn) != 0) Configure(kLowPowerClock | kCommand32 | kUpdate, 0xFFFF);
}

void StartWatchdog() noexcept { Configure(kOn | kLowPowerClock | kCommand32 | kInWait, kTimeoutTicks); }

void FeedWatchdog() noexcept {
  const Critical critical;
  wdog3().CNT = kRefresh;
}

}  // namespace omni::board
