// The chip's memories as this board divides them. The linker script repeats these numbers; the layout test compares.
// RM: i.MX RT1060 Processor Reference Manual (IMXRT1060RM); chapters are cited by name, because page numbers change.
#pragma once

#include <cstdint>

namespace omni::board {

constexpr std::uint32_t kFlashBase = 0x60000000;
constexpr std::uint32_t kFlashSize = 0x200000;  // W25Q16JV, 2 MB
// The boot loader's own restore program lives in the last 64 KB [PJRC, Teensy 4.0 technical information].
constexpr std::uint32_t kFlashUsable = kFlashSize - 0x10000;
constexpr std::uint32_t kIvtAddress = kFlashBase + 0x1000;  // RM System Boot, FlexSPI NOR image offset

// FlexRAM: 16 banks of 32 KB, assigned by a register [RM FlexRAM]. Code 128 KB, data 384 KB: fixed, so that the stack
// does not move with the code's size.
constexpr std::uint32_t kFlexRamBank = 0x8000;
constexpr int kFlexRamBanks = 16;
constexpr int kItcmBanks = 4;
constexpr int kDtcmBanks = kFlexRamBanks - kItcmBanks;
constexpr std::uint32_t kItcmBase = 0x00000000;
constexpr std::uint32_t kItcmSize = kItcmBanks * kFlexRamBank;
constexpr std::uint32_t kDtcmBase = 0x20000000;
constexpr std::uint32_t kDtcmSize = kDtcmBanks * kFlexRamBank;

// The first bytes of ITCM are empty and inaccessible: a null pointer faults.
constexpr std::uint32_t kNullTrapSize = 0x400;

// On-chip RAM outside of FlexRAM. Not cached here: it holds USB buffers and the data kept across a reset.
constexpr std::uint32_t kOcramBase = 0x20200000;
constexpr std::uint32_t kOcramSize = 0x80000;
// The boot ROM works in the first 32 KB [RM System Boot, ROM memory map]; retained data is at the far end.
constexpr std::uint32_t kOcramOfRom = 0x8000;
constexpr std::uint32_t kRetainedSize = 0x100;
constexpr std::uint32_t kRetainedAddress = kOcramBase + kOcramSize - kRetainedSize;

// At the bottom of DTCM: an overflow leaves the memory and faults instead of overwriting variables.
constexpr std::uint32_t kStackSize = 0x8000;

// GPR17, two bits per bank: 3 ITCM, 2 DTCM, 1 OCRAM [RM IOMUXC_GPR, GPR17].
constexpr std::uint32_t kFlexRamBankConfig = 0xAAAAAAAAU | ((1U << (2 * kItcmBanks)) - 1);
static_assert(kFlexRamBankConfig == 0xAAAAAAFFU, "start-up code repeats this number in assembly");

}  // namespace omni::board
