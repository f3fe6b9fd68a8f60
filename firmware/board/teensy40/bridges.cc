#include "firmware/board/teensy40/bridges.h"

#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {
namespace {

// RM FlexPWM.
constexpr std::uint16_t kIndependent = 1U << 13, kRunInWait = 1U << 14;  // CTRL2; not kept running under a debugger
constexpr std::uint16_t kReloadEveryPeriod = 1U << 10;                   // CTRL.FULL
constexpr std::uint16_t kAllFaultsStopA = 0x000F;                        // DISMAP0.DIS0A
constexpr std::uint16_t kFaultLevels = 0x8000;      // FCTRL.FLVL: 0 to 2 are low when bad, 3 (the switch) is high
constexpr std::uint16_t kAllFlags = 0x000F;         // FSTS.FFLAG, written ones clear
constexpr std::uint16_t kRestartAtPeriod = 0x00F0;  // FSTS.FFULL
// Three equal samples 16 bus clocks apart: 0.3 us. The direct path beside the filter stays on, it brakes at once.
constexpr std::uint16_t kFilter = 16;
constexpr std::uint16_t kLoad(std::uint16_t submodules) { return submodules; }
constexpr std::uint16_t kClearLoad(std::uint16_t submodules) { return static_cast<std::uint16_t>(submodules << 4); }
constexpr std::uint16_t kRun(std::uint16_t submodules) { return static_cast<std::uint16_t>(submodules << 8); }
constexpr std::uint16_t kOutputA(std::uint16_t submodules) { return static_cast<std::uint16_t>(submodules << 8); }
constexpr std::uint16_t kThree = 0x7;
constexpr std::uint8_t kSwitchBit = 1U << 3;

// RM XBAR: outputs to FlexPWM2's faults; inputs are the numbers of XBAR1_INOUTnn.
struct Route {
  std::uint8_t output, input;
};
constexpr Route kFaultRoutes[] = {{49, 6}, {50, 7}, {37, 17}, {38, 14}};

void Connect(const Route& route) noexcept {
  Reg16& select = XbarSelect(route.output);
  const int shift = (route.output & 1) != 0 ? 8 : 0;
  select = static_cast<std::uint16_t>((select & ~(0xFF << shift)) | (route.input << shift));
}

void SetUpSubmodule(PwmSubmodule& submodule, std::uint16_t ticks) noexcept {
  submodule.CTRL2 = kIndependent | kRunInWait;
  submodule.CTRL = kReloadEveryPeriod;
  submodule.OCTRL = 0;  // not inverted, low on a fault
  submodule.DTCNT0 = submodule.DTCNT1 = 0;
  submodule.INIT = 0;
  submodule.VAL0 = 0;
  submodule.VAL1 = static_cast<std::uint16_t>(ticks - 1);
  submodule.VAL2 = submodule.VAL3 = 0;
  submodule.VAL4 = submodule.VAL5 = 0;
}

std::uint8_t Flags() noexcept { return static_cast<std::uint8_t>(flexpwm2().FSTS & 0xF); }
std::uint8_t Lines() noexcept { return static_cast<std::uint8_t>(flexpwm2().FSTS >> 8 & 0xF); }

}  // namespace

void Bridges::Start() noexcept {
  FlexPwm& pwm = flexpwm2();
  driven_ = 0;
  pwm.OUTEN = 0;
  pwm.MCTRL = kClearLoad(kThree);
  for (int i = 0; i < kBridges; ++i) {
    SetUpSubmodule(pwm.SM[i], kPwmTicks);
    pwm.SM[i].DISMAP0 = kAllFaultsStopA;
  }
  // Until they are routed, the coils' lines read low: outputs start out held low.
  pwm.FCTRL = kFaultLevels;
  pwm.FFILT = kFilter;
  for (const Route& route : kFaultRoutes) Connect(route);
  pwm.FSTS = kRestartAtPeriod | kAllFlags;
  pwm.MCTRL |= kLoad(kThree);
  pwm.OUTEN = kOutputA(kThree);
  pwm.MCTRL |= kRun(kThree);
}

std::uint8_t Bridges::CoilFaults() const noexcept { return (Flags() | Lines()) & 0x7; }
bool Bridges::EmergencyStop() const noexcept { return ((Flags() | Lines()) & kSwitchBit) != 0; }
std::uint8_t Bridges::CoilFaultLines() const noexcept { return Lines() & 0x7; }

void Bridges::ClearFaults() noexcept {
  const auto well = static_cast<std::uint8_t>(Flags() & ~Lines());
  if (well != 0) flexpwm2().FSTS = kRestartAtPeriod | well;
}

void Bridges::SetDuty(int index, std::uint16_t duty) noexcept {
  FlexPwm& pwm = flexpwm2();
  const auto mask = static_cast<std::uint16_t>(1U << index);
  driven_ = static_cast<std::uint8_t>(duty != 0 ? driven_ | mask : driven_ & ~mask);
  pwm.MCTRL |= kClearLoad(mask);  // a half-written set is never loaded
  pwm.SM[index].VAL3 = PwmHighTicks(duty);
  pwm.MCTRL |= kLoad(mask);
}

void Bridges::Pins::SetDirection(bool negative) noexcept {
  SetPin(static_cast<Signal>(static_cast<int>(Signal::kBridgeDirection0) + index_), negative);
}

void Bridges::Pins::SetAwake(bool awake) noexcept {
  SetPin(static_cast<Signal>(static_cast<int>(Signal::kBridgeAwake0) + index_), awake);
}

void FanPwm::Start() noexcept {
  FlexPwm& pwm = flexpwm4();
  pwm.MCTRL = kClearLoad(1);
  SetUpSubmodule(pwm.SM[0], kBus_Hz / 25'000);
  pwm.SM[0].DISMAP0 = 0;  // no fault of a coil stops the fan
  pwm.MCTRL |= kLoad(1);
  pwm.OUTEN = kOutputA(1);
  pwm.MCTRL |= kRun(1);
}

void FanPwm::Set(std::uint8_t of_255) noexcept {
  FlexPwm& pwm = flexpwm4();
  pwm.MCTRL |= kClearLoad(1);
  pwm.SM[0].VAL3 = static_cast<std::uint16_t>(of_255 * (kBus_Hz / 25'000) / 255);
  pwm.MCTRL |= kLoad(1);
}

}  // namespace omni::board
