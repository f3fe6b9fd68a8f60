#include "firmware/board/teensy40/watchdog.h"

#include "firmware/board/teensy40/chip/critical.h"
#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {
namespace {

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

void StopWatchdogOfRom() noexcept {
  if ((wdog3().CS & kOn) != 0) Configure(kLowPowerClock | kCommand32 | kUpdate, 0xFFFF);
}

void StartWatchdog() noexcept { Configure(kOn | kLowPowerClock | kCommand32 | kInWait, kTimeoutTicks); }

void FeedWatchdog() noexcept {
  const Critical critical;
  wdog3().CNT = kRefresh;
}

}  // namespace omni::board
