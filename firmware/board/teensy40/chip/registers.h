// Registers of the i.MX RT1062 that this board uses, and only those bits. RM: IMXRT1060RM; each block cites
// its chapter, and its layout is checked below against its offsets.
#pragma once

#include <cstddef>
#include <cstdint>

#include "firmware/board/teensy40/chip/cpu.h"

namespace omni::board {

template <std::size_t kBytes>
struct Gap {
  std::uint8_t unused[kBytes];
};

// RM IOMUXC_GPR, GPR1 at +4.
inline Reg32& Gpr(std::uint32_t number) noexcept { return RegisterAt(0x400AC000 + 4 * number); }

// RM Clock Controller Module (CCM).
struct Ccm {
  Gap<0x10> gap0;
  Reg32 CACRR, CBCDR, CBCMR, CSCMR1;
  Gap<0x18> gap1;
  Reg32 CSCDR2;
  Gap<0x0C> gap2;
  Reg32 CDHIPR;
  Gap<0x08> gap3;
  Reg32 CLPCR;
  Gap<0x10> gap4;
  Reg32 CCGR[8];
};
static_assert(offsetof(Ccm, CSCMR1) == 0x1C && offsetof(Ccm, CSCDR2) == 0x38 && offsetof(Ccm, CDHIPR) == 0x48 &&
                  offsetof(Ccm, CLPCR) == 0x54 && offsetof(Ccm, CCGR) == 0x68,
              "CCM");
inline Ccm& ccm() noexcept { return Block<Ccm>(0x400FC000); }

namespace ccm_bits {
constexpr std::uint32_t kArmPodfMask = 7U;         // CACRR
constexpr std::uint32_t kPeriphClock2 = 1U << 25;  // CBCDR.PERIPH_CLK_SEL
constexpr std::uint32_t kPeriphClock2PodfMask = 7U << 27;
constexpr std::uint32_t kAhbPodfMask = 7U << 10;
constexpr std::uint32_t kIpgPodfMask = 3U << 8;
constexpr std::uint32_t kIpgBy4 = 3U << 8;
constexpr std::uint32_t kPeriphClock2SelMask = 3U << 12;  // CBCMR
constexpr std::uint32_t kPeriphClock2Osc = 1U << 12;
constexpr std::uint32_t kPrePeriphMask = 3U << 18;
constexpr std::uint32_t kPrePeriphArmPll = 3U << 18;
constexpr std::uint32_t kLpspiMask = (7U << 26) | (3U << 4);
constexpr std::uint32_t kLpspiPll2By8 = (7U << 26) | (2U << 4);
constexpr std::uint32_t kPerclkMask = 0x7FU;  // CSCMR1
constexpr std::uint32_t kPerclkOsc = 1U << 6;
constexpr std::uint32_t kLpi2cMask = 0x7FU << 18;  // CSCDR2; all zero: PLL3 / 8, 60 MHz
constexpr std::uint32_t kBusyPeriph2 = 1U << 3;    // CDHIPR
constexpr std::uint32_t kBusyPeriph = 1U << 5;
constexpr std::uint32_t kBusyArmPodf = 1U << 16;
constexpr std::uint32_t kBusyAhbPodf = 1U << 1;
constexpr std::uint32_t kLowPowerModeMask = 3U;  // CLPCR; 0: stay in run mode
}  // namespace ccm_bits

// Clock gates, both bits on [RM CCM, CCGR0 to CCGR7].
constexpr std::uint32_t GateOn(int field) noexcept { return 3U << (2 * field); }

// RM CCM_ANALOG, PMU, TEMPMON: one block of registers with set and clear twins.
struct Twin {
  Reg32 value, set, clear, toggle;
};
struct Analog {
  Twin PLL_ARM, PLL_USB1, gap0, PLL_SYS;
  Gap<0xB0> gap1;
  Twin PFD_480, PFD_528;
  Twin PMU_REG_1P1, PMU_REG_3P0, PMU_REG_2P5, PMU_REG_CORE, MISC0;
  Gap<0x20> gap2;
  Twin TEMPSENSE0, TEMPSENSE1;
};
static_assert(offsetof(Analog, PLL_SYS) == 0x30 && offsetof(Analog, PFD_480) == 0xF0 &&
                  offsetof(Analog, PMU_REG_3P0) == 0x120 && offsetof(Analog, MISC0) == 0x150 &&
                  offsetof(Analog, TEMPSENSE0) == 0x180,
              "CCM_ANALOG, PMU, TEMPMON");
inline Analog& analog() noexcept { return Block<Analog>(0x400D8000); }

namespace analog_bits {
constexpr std::uint32_t kLock = 1U << 31;
constexpr std::uint32_t kBypass = 1U << 16;
constexpr std::uint32_t kEnable = 1U << 13;
constexpr std::uint32_t kPowerDown = 1U << 12;  // of PLL_ARM and PLL_SYS
constexpr std::uint32_t kUsbPower = 1U << 12;   // of PLL_USB1: with the opposite meaning
constexpr std::uint32_t kUsbClocks = 1U << 6;
constexpr std::uint32_t kUsbDiv22 = 1U << 1;
constexpr std::uint32_t kArmDivideMask = 0x7F;
constexpr std::uint32_t kSelfBiasOff = 1U << 3;                        // MISC0.REFTOP_SELFBIASOFF
constexpr std::uint32_t kUsbRegulator = (0xFU << 8) | (6U << 4) | 1U;  // REG_3P0: 3.0 V, brown-out 6, on
constexpr std::uint32_t kTempPowerDown = 1U, kTempMeasure = 2U, kTempFinished = 4U;
}  // namespace analog_bits

// RM DCDC Converter.
constexpr std::uint32_t kDcdcReg0 = 0x40080000, kDcdcReg3 = 0x4008000C;
constexpr std::uint32_t kDcdcOk = 1U << 31;
constexpr std::uint32_t kDcdcTargetMask = 0x1F;

// RM Fuse map: factory calibration of the thermometer, unique number.
constexpr std::uint32_t kFuseThermometer = 0x401F44E0, kFuseUnique0 = 0x401F4410, kFuseUnique1 = 0x401F4420;

// RM System Reset Controller: SRSR, written ones clear.
constexpr std::uint32_t kResetStatus = 0x400F8008;
constexpr std::uint32_t kResetBySoftware = 1U << 1;  // or by a locked-up core
constexpr std::uint32_t kResetByWatchdogs = (1U << 4) | (1U << 7);

// RM General Purpose Input/Output; GPIO6 to GPIO9 are the fast twins of GPIO1 to GPIO4.
struct Gpio {
  Reg32 DR, GDIR, PSR;
  Gap<0x78> gap0;
  Reg32 DR_SET, DR_CLEAR;
};
static_assert(offsetof(Gpio, DR_SET) == 0x84, "GPIO");
inline Gpio& FastGpio(int port) noexcept {  // 1 to 4
  return Block<Gpio>(0x42000000U + 0x4000U * static_cast<std::uint32_t>(port - 1));
}

// RM Low Power Serial Peripheral Interface.
struct Lpspi {
  Gap<0x10> gap0;
  Reg32 CR, SR, IER, DER, CFGR0, CFGR1;
  Gap<0x18> gap1;
  Reg32 CCR;
  Gap<0x14> gap2;
  Reg32 FCR, FSR, TCR, TDR;
  Gap<0x08> gap3;
  Reg32 RSR, RDR;
};
static_assert(offsetof(Lpspi, CFGR1) == 0x24 && offsetof(Lpspi, CCR) == 0x40 && offsetof(Lpspi, TCR) == 0x60 &&
                  offsetof(Lpspi, RDR) == 0x74,
              "LPSPI");
inline Lpspi& lpspi4() noexcept { return Block<Lpspi>(0x403A0000); }

// RM Low Power Inter-Integrated Circuit, master half.
struct Lpi2c {
  Gap<0x10> gap0;
  Reg32 MCR, MSR, MIER, MDER, MCFGR0, MCFGR1, MCFGR2, MCFGR3;
  Gap<0x18> gap1;
  Reg32 MCCR0;
  Gap<0x04> gap2;
  Reg32 MCCR1;
  Gap<0x04> gap3;
  Reg32 MFCR, MFSR, MTDR;
  Gap<0x0C> gap4;
  Reg32 MRDR;
};
static_assert(offsetof(Lpi2c, MCFGR1) == 0x24 && offsetof(Lpi2c, MCCR0) == 0x48 && offsetof(Lpi2c, MCCR1) == 0x50 &&
                  offsetof(Lpi2c, MTDR) == 0x60 && offsetof(Lpi2c, MRDR) == 0x70,
              "LPI2C");
inline Lpi2c& lpi2c1() noexcept { return Block<Lpi2c>(0x403F0000); }

// RM Enhanced Flex Pulse Width Modulator.
struct PwmSubmodule {
  Reg16 CNT, INIT, CTRL2, CTRL, gap0, VAL0, FRACVAL1, VAL1, FRACVAL2, VAL2, FRACVAL3, VAL3, FRACVAL4, VAL4, FRACVAL5,
      VAL5, FRCTRL, OCTRL, STS, INTEN, DMAEN, TCTRL, DISMAP0, DISMAP1, DTCNT0, DTCNT1;
  Gap<0x60 - 0x34> gap1;
};
struct FlexPwm {
  PwmSubmodule SM[4];
  Reg16 OUTEN, MASK, SWCOUT, DTSRCSEL, MCTRL, MCTRL2, FCTRL, FSTS, FFILT;
};
static_assert(sizeof(PwmSubmodule) == 0x60 && offsetof(PwmSubmodule, VAL3) == 0x16 &&
                  offsetof(PwmSubmodule, DISMAP0) == 0x2C && offsetof(FlexPwm, MCTRL) == 0x188 &&
                  offsetof(FlexPwm, FSTS) == 0x18E,
              "FlexPWM");
inline FlexPwm& flexpwm2() noexcept { return Block<FlexPwm>(0x403E0000); }
inline FlexPwm& flexpwm4() noexcept { return Block<FlexPwm>(0x403E8000); }

// RM Inter-Peripheral Crossbar Switch A1: one byte per output.
inline Reg16& XbarSelect(std::uint32_t output) noexcept { return Block<Reg16>(0x403BC000 + 2 * (output / 2)); }

// RM General Purpose Timer.
struct Gpt {
  Reg32 CR, PR, SR, IR, OCR1, OCR2, OCR3, ICR1, ICR2, CNT;
};
static_assert(offsetof(Gpt, CNT) == 0x24, "GPT");
inline Gpt& gpt2() noexcept { return Block<Gpt>(0x401F0000); }

// RM Periodic Interrupt Timer.
struct PitChannel {
  Reg32 LDVAL, CVAL, TCTRL, TFLG;
};
struct Pit {
  Reg32 MCR;
  Gap<0xFC> gap0;
  PitChannel channel[4];
};
static_assert(offsetof(Pit, channel) == 0x100, "PIT");
inline Pit& pit() noexcept { return Block<Pit>(0x40084000); }

// RM RT Watchdog (RTWDOG, WDOG3).
struct RtWatchdog {
  Reg32 CS, CNT, TOVAL, WIN;
};
inline RtWatchdog& wdog3() noexcept { return Block<RtWatchdog>(0x400BC000); }

// RM Universal Serial Bus Controller and USB PHY; the device half belongs to firmware/drivers.
constexpr std::uint32_t kUsb1Base = 0x402E0000;
constexpr std::uint32_t kUsb1BurstSize = kUsb1Base + 0x160, kUsb1Command = kUsb1Base + 0x140,
                        kUsb1Mode = kUsb1Base + 0x1A8;
struct UsbPhy {
  Twin PWD;
  Gap<0x20> gap0;
  Twin CTRL;
};
static_assert(offsetof(UsbPhy, CTRL) == 0x30, "USBPHY");
inline UsbPhy& usbphy1() noexcept { return Block<UsbPhy>(0x400D9000); }

}  // namespace omni::board
