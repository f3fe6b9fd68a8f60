// From the boot ROM's jump to main: assigns FlexRAM, copies code and data, clears and protects memory, and handles
// faults. Nothing here may call code outside of .startup before the copy.
#include <cstdint>
#include <initializer_list>

#include "firmware/board/teensy40/boot/memory_map.h"
#include "firmware/board/teensy40/boot/retained.h"
#include "firmware/board/teensy40/chip/chip.h"
#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/board/teensy40/chip/cpu.h"
#include "firmware/board/teensy40/chip/pins.h"

extern "C" {
extern std::uint32_t __itcm_begin[], __itcm_end[], __itcm_load[];
extern std::uint32_t __data_begin[], __data_end[], __data_load[];
extern std::uint32_t __bss_begin[], __bss_end[];
extern std::uint32_t __shared_begin[], __shared_end[];
extern void (*__init_array_begin[])();
extern void (*__init_array_end[])();

[[noreturn]] void ResetHandler();
[[noreturn]] void StartUp();
[[noreturn]] void FaultEntry();
[[noreturn]] void BrakeAndReset();
void OnCurrentBus();
void OnUsb();
void OnControlStep();
int main();
}

#define OMNI_STARTUP __attribute__((section(".startup"), noinline))

// GPR17: assignment of the banks; GPR16: both memories on, banks by GPR17; GPR14: both up to 512 KB [RM IOMUXC_GPR].
// The stack is in what these make, so no stack before them. Interrupts stay off until main turns them on.
__attribute__((naked, section(".startup.reset"))) void ResetHandler() {
  asm volatile(
      "cpsid i\n"
      "ldr r0, =0x400AC000\n"
      "ldr r1, =0xAAAAAAFF\n"
      "str r1, [r0, #0x44]\n"
      "ldr r1, =0x00200007\n"
      "str r1, [r0, #0x40]\n"
      "ldr r1, =0x00AA0000\n"
      "str r1, [r0, #0x38]\n"
      "dsb\n"
      "isb\n"
      "ldr sp, =__stack_top\n"
      "b StartUp\n"
      ".ltorg\n");
}

namespace omni::board {
namespace {

OMNI_STARTUP void Copy(std::uint32_t* to, const std::uint32_t* end, const std::uint32_t* from) noexcept {
  while (to < end) *to++ = *from++;
}

OMNI_STARTUP void Clear(std::uint32_t* to, const std::uint32_t* end) noexcept {
  while (to < end) *to++ = 0;
}

// One region of the memory protection unit [ARM B3.5.9]. Higher numbers win. Attribute bits: TEX, C, B, S.
struct Region {
  std::uint32_t base;
  std::uint32_t size_log2;
  std::uint32_t attributes;
};
constexpr std::uint32_t kNoAccess = 0, kReadWrite = 3U << 24, kReadOnly = 7U << 24, kNoExecute = 1U << 28;
constexpr std::uint32_t kNormalUncached = 1U << 19, kNormalWriteThrough = 1U << 17, kDevice = 2U << 19;

constexpr Region kRegions[] = {
    {0x00000000, 32, kNoAccess | kNoExecute},  // all that is not listed below, also for speculative reads
    {kItcmBase, 19, kReadOnly | kNormalUncached},
    {kItcmBase, 10, kNoAccess | kNoExecute},  // null pointers
    {kDtcmBase, 19, kReadWrite | kNormalUncached | kNoExecute},
    {kOcramBase, 20, kReadWrite | kNormalUncached | kNoExecute},
    {0x40000000, 26, kReadWrite | kDevice | kNoExecute},
    {kFlashBase, 21, kReadOnly | kNormalWriteThrough},
};
static_assert(kNullTrapSize == 1U << 10 && kFlashSize == 1U << 21, "regions");

void ProtectMemory() noexcept {
  mpu::Control() = 0;
  std::uint32_t number = 0;
  for (const Region& region : kRegions) {
    mpu::RegionBase() = region.base | 1U << 4 | number++;
    mpu::RegionSize() = region.attributes | (region.size_log2 - 1) << 1 | 1U;
  }
  DataBarrier();
  mpu::Control() = 1;
  DataBarrier();
  InstructionBarrier();
  // Only start-up code in flash benefits. No data are cached: everything is in DTCM or shared with USB.
  scb::InvalidateInstructionCache() = 0;
  DataBarrier();
  InstructionBarrier();
  scb::ConfigControl() |= scb::kInstructionCacheOn;
  DataBarrier();
  InstructionBarrier();
}

struct VectorTable {
  std::uint32_t* stack;
  void (*handlers[kVectors - 1])();
};
extern "C" std::uint32_t __stack_top[];

constexpr VectorTable MakeVectors() {
  VectorTable table{__stack_top, {}};
  for (auto& handler : table.handlers) handler = FaultEntry;  // also every unused interrupt
  table.handlers[0] = ResetHandler;
  table.handlers[kCoreVectors - 1 + static_cast<int>(Irq::kLpi2c1)] = OnCurrentBus;
  table.handlers[kCoreVectors - 1 + static_cast<int>(Irq::kUsb1)] = OnUsb;
  table.handlers[kCoreVectors - 1 + static_cast<int>(Irq::kPit)] = OnControlStep;
  return table;
}
__attribute__((section(".vectors"), used, aligned(1024))) constexpr VectorTable kVectorTable = MakeVectors();
static_assert(sizeof(void*) != 4 || sizeof(VectorTable) == 4 * kVectors, "core and chip interrupts");

constexpr std::uint32_t kBrake_us = 10'000;  // more than six time constants of a coil
constexpr std::uint32_t kFeedEvery_us = 1000;

}  // namespace
}  // namespace omni::board

OMNI_STARTUP void StartUp() {
  using namespace omni::board;
  Copy(__itcm_begin, __itcm_end, __itcm_load);
  Copy(__data_begin, __data_end, __data_load);
  Clear(__bss_begin, __bss_end);
  Clear(__shared_begin, __shared_end);
  dwt::Start();
  scb::CoprocessorAccess() |= scb::kFpuFullAccess;
  DataBarrier();
  InstructionBarrier();
  scb::VectorTable() = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&kVectorTable));
  scb::HandlerControl() |= scb::kFaultHandlersOn;
  ProtectMemory();
  OpenClockGates();
  StopWatchdogOfRom();
  SetUpPins();  // bridges asleep and braked before anything else
  for (auto* constructor = __init_array_begin; constructor < __init_array_end; ++constructor) (*constructor)();
  main();
  BrakeAndReset();
}

// A fresh stack: the old one may be the cause.
__attribute__((naked)) void FaultEntry() {
  asm volatile(
      "cpsid i\n"
      "ldr r0, =__stack_top\n"
      "msr msp, r0\n"
      "b BrakeAndReset\n"
      ".ltorg\n");
}

// Brake until the coils' energy is gone, and only then let the bridges sleep: asleep they would feed it into the
// supply. A watchdog reset cannot wait; for that case README.md specifies a capacitor.
void BrakeAndReset() {
  using namespace omni::board;
  InterruptsOff();
  PwmPadsToGround();
  dwt::Start();  // it may not have been started yet
  nvic::DisableAll();
  retained().crashed = kCrashed;
  for (std::uint32_t waited = 0; waited < kBrake_us; waited += kFeedEvery_us) {
    FeedWatchdog();
    BusyWait(kFeedEvery_us);
  }
  for (const Signal awake : {Signal::kBridgeAwake0, Signal::kBridgeAwake1, Signal::kBridgeAwake2}) SetPin(awake, false);
  DataBarrier();
  scb::ResetControl() = scb::kResetRequest;
  for (;;) FeedWatchdog();
}
