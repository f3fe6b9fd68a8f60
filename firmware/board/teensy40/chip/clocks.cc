#include "firmware/board/teensy40/chip/clocks.h"

#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {
namespace {

// 1.25 V, in steps of 25 mV from 0.8 V: what 600 MHz needs [IMXRT1060CEC data sheet, operating ranges].
constexpr std::uint32_t kCoreVoltage = (1250 - 800) / 25;
// 24 MHz * 100 / 2 = 1200 MHz, halved by ARM_PODF.
constexpr std::uint32_t kArmMultiplier = 100;
constexpr std::uint32_t kArmPodfBy2 = 1;
static_assert(24 * kArmMultiplier / 2 / (kArmPodfBy2 + 1) == kCore_MHz, "core clock");
static_assert(kCore_MHz * 1'000'000 / 4 == kBus_Hz, "IPG is a quarter of the core's");

void WaitWhile(std::uint32_t busy) noexcept {
  while ((ccm().CDHIPR & busy) != 0) {
  }
}

void WaitLock(const Twin& pll) noexcept {
  while ((pll.value & analog_bits::kLock) == 0) {
  }
}

void RaiseVoltage() noexcept {
  const std::uint32_t now = RegisterAt(kDcdcReg3);
  if ((now & kDcdcTargetMask) >= kCoreVoltage) return;
  RegisterAt(kDcdcReg3) = (now & ~kDcdcTargetMask) | kCoreVoltage;
  while ((RegisterAt(kDcdcReg0) & kDcdcOk) == 0) {
  }
}

// 480 MHz: USB, and the 60 MHz of I2C.
void StartUsbPll() noexcept {
  Twin& pll = analog().PLL_USB1;
  if ((pll.value & analog_bits::kUsbDiv22) != 0) {  // 528 MHz: not usable for USB
    pll.set = analog_bits::kBypass;
    pll.clear = analog_bits::kUsbPower | analog_bits::kUsbDiv22 | analog_bits::kEnable | analog_bits::kUsbClocks;
  }
  pll.set = analog_bits::kEnable | analog_bits::kUsbPower;
  WaitLock(pll);
  pll.clear = analog_bits::kBypass;
  pll.set = analog_bits::kUsbClocks;
}

// 528 MHz, for SPI; the ROM has it running for the flash.
void StartSystemPll() noexcept {
  Twin& pll = analog().PLL_SYS;
  pll.clear = analog_bits::kPowerDown;
  pll.set = analog_bits::kEnable;
  WaitLock(pll);
  pll.clear = analog_bits::kBypass;
}

// The core runs from the crystal while its PLL is set up: 24 MHz is slow but always valid.
void SwitchCore() noexcept {
  Ccm& c = ccm();
  c.CBCMR = (c.CBCMR & ~ccm_bits::kPeriphClock2SelMask) | ccm_bits::kPeriphClock2Osc;
  WaitWhile(ccm_bits::kBusyPeriph2);
  c.CBCDR &= ~ccm_bits::kPeriphClock2PodfMask;
  c.CBCDR |= ccm_bits::kPeriphClock2;
  WaitWhile(ccm_bits::kBusyPeriph);

  Twin& pll = analog().PLL_ARM;
  pll.value = analog_bits::kPowerDown;
  pll.value = analog_bits::kEnable | kArmMultiplier;
  WaitLock(pll);
  c.CACRR = kArmPodfBy2;
  WaitWhile(ccm_bits::kBusyArmPodf);
  c.CBCMR = (c.CBCMR & ~ccm_bits::kPrePeriphMask) | ccm_bits::kPrePeriphArmPll;

  c.CBCDR &= ~ccm_bits::kAhbPodfMask;
  WaitWhile(ccm_bits::kBusyAhbPodf);
  c.CBCDR = (c.CBCDR & ~ccm_bits::kIpgPodfMask) | ccm_bits::kIpgBy4;
  c.CBCDR &= ~ccm_bits::kPeriphClock2;
  WaitWhile(ccm_bits::kBusyPeriph);
}

}  // namespace

void OpenClockGates() noexcept {
  ccm().CCGR[0] |= GateOn(12) | GateOn(13) | GateOn(15);             // GPT2, GPIO2
  ccm().CCGR[1] |= GateOn(3) | GateOn(6) | GateOn(13);               // LPSPI4, PIT, GPIO1
  ccm().CCGR[2] |= GateOn(3) | GateOn(6) | GateOn(11) | GateOn(13);  // LPI2C1, OCOTP, XBAR1, GPIO3
  ccm().CCGR[3] |= GateOn(6);                                        // GPIO4
  ccm().CCGR[4] |= GateOn(1) | GateOn(2) | GateOn(9) | GateOn(11);   // IOMUXC, its GPR, PWM2, PWM4
  ccm().CCGR[5] |= GateOn(2);                                        // WDOG3
  ccm().CCGR[6] |= GateOn(0) | GateOn(3);                            // USB, DCDC
}

void SetUpPeripheralClocks() noexcept {
  Ccm& c = ccm();
  c.CSCMR1 = (c.CSCMR1 & ~ccm_bits::kPerclkMask) | ccm_bits::kPerclkOsc;
  c.CSCDR2 &= ~ccm_bits::kLpi2cMask;
  c.CBCMR = (c.CBCMR & ~ccm_bits::kLpspiMask) | ccm_bits::kLpspiPll2By8;
  static_assert(528'000'000 / 8 == kSpiSource_Hz && 480'000'000 / 8 == kI2cSource_Hz, "sources");
}

void SetUpClocks() noexcept {
  // Waiting for an interrupt stops the core only; in the reset setting it would stop the buses too [RM CCM, CLPCR].
  ccm().CLPCR &= ~ccm_bits::kLowPowerModeMask;
  analog().MISC0.set = analog_bits::kSelfBiasOff;
  RaiseVoltage();
  StartUsbPll();
  StartSystemPll();
  SwitchCore();
  SetUpPeripheralClocks();
}

}  // namespace omni::board
