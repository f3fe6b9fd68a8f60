// From reset to Main: FPU, memory, constructors. An exception ends the emulator with a status that contains its number.
#include "firmware/board/mps2_an500/start.h"

#include <cstddef>

#include "firmware/board/mps2_an500/host_link.h"
#include "firmware/board/mps2_an500/semihosting.h"
#include "firmware/board/mps2_an500/text.h"

// Of the linker script.
extern "C" {
extern std::uint32_t _stack_limit[], _stack_top[];
extern std::uint32_t _data_load[], _data_begin[], _data_end[];
extern std::uint32_t _bss_begin[], _bss_end[];
extern void (*_init_array_begin[])();
extern void (*_init_array_end[])();

void Reset_Handler();
void Exception_Handler();
[[noreturn]] void Start();
[[noreturn]] void ReportException(std::uint32_t number, const std::uint32_t* frame);
}

namespace omni::firmware::board {
namespace {

constexpr std::uint32_t kPaint = 0xA5A5A5A5U;

// System control block [ARMv7-M, B3.2.2].
volatile std::uint32_t& Register(std::uintptr_t address) noexcept {
  return *reinterpret_cast<volatile std::uint32_t*>(address);
}
constexpr std::uintptr_t kAircr = 0xE000ED0C;       // application interrupt and reset control
constexpr std::uintptr_t kCcr = 0xE000ED14;         // configuration and control
constexpr std::uintptr_t kShcsr = 0xE000ED24;       // system handler control and state
constexpr std::uintptr_t kCfsr = 0xE000ED28;        // configurable fault status
constexpr std::uintptr_t kMpuControl = 0xE000ED94;  // memory protection unit [ARMv7-M, B3.5]
constexpr std::uintptr_t kMpuRegion = 0xE000ED98;
constexpr std::uintptr_t kMpuBase = 0xE000ED9C;
constexpr std::uintptr_t kMpuSize = 0xE000EDA0;
constexpr std::uint32_t kResetRequest = 0x05FA0000U | (1U << 2);
constexpr std::uint32_t kDivideByZeroTraps = 1U << 4;
constexpr std::uint32_t kMemoryBusUsageFaults = 7U
                                                << 16;  // reported with their own numbers, instead of as a hard fault

using Handler = void (*)();
struct VectorTable {  // [ARMv7-M, B1.5.3]
  const void* initial_stack;
  Handler exceptions[15];
  Handler interrupts[32];  // AN500 has 32; none is used
};
constexpr Handler kX = Exception_Handler;

__attribute__((section(".vectors"), used))
const VectorTable kVectors = {_stack_top,
                              {Reset_Handler, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX},
                              {kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX,
                               kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX, kX}};

}  // namespace

std::uint32_t StackUsed_bytes() noexcept {
  const volatile std::uint32_t* word = _stack_limit;
  while (word < _stack_top && *word == kPaint) ++word;
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(_stack_top) -
                                    reinterpret_cast<std::uintptr_t>(word));
}

std::uint32_t StackSize_bytes() noexcept {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(_stack_top) -
                                    reinterpret_cast<std::uintptr_t>(_stack_limit));
}

void ResetMachine() noexcept {
  __asm__ volatile("dsb" ::: "memory");
  Register(kAircr) = kResetRequest;
  __asm__ volatile("dsb" ::: "memory");
  for (;;) {  // takes effect a little later
  }
}

namespace {

void PrepareMemory() noexcept {
  // Volatile, so that no loop becomes a call that would use the stack being painted.
  const std::uint32_t here = 0;
  for (volatile std::uint32_t* word = _stack_limit; word + 32 < &here; ++word) *word = kPaint;
  const volatile std::uint32_t* from = _data_load;
  for (volatile std::uint32_t* to = _data_begin; to < _data_end; ++to, ++from) *to = *from;
  for (volatile std::uint32_t* word = _bss_begin; word < _bss_end; ++word) *word = 0;
}

// No access to the 16 MB below RAM, where an overflowing stack continues; the board itself would ignore it.
void GuardStack() noexcept {
  constexpr std::uint32_t kNoAccessNoExecute = 1U << 28;
  constexpr std::uint32_t kSize16MB = 23U << 1;
  constexpr std::uint32_t kDefaultMapElsewhere = 1U << 2;
  Register(kMpuRegion) = 0;
  Register(kMpuBase) = static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(_stack_limit)) - (1U << 24);
  Register(kMpuSize) = kNoAccessNoExecute | kSize16MB | 1U;
  Register(kMpuControl) = kDefaultMapElsewhere | 1U;
  __asm__ volatile("dsb\n isb" ::: "memory");
}

// The words after the first, which is the program's name.
const char* WithoutName(const char* text) noexcept {
  while (*text != '\0' && *text != ' ') ++text;
  while (*text == ' ') ++text;
  return text;
}

}  // namespace
}  // namespace omni::firmware::board

using namespace omni::firmware::board;  // NOLINT(google-build-using-namespace): the entry points below have C names

// The FPU first [ARMv7-M, B3.2.20: CPACR, full access to CP10 and CP11]: any C++ may use its registers.
extern "C" __attribute__((naked)) void Reset_Handler() {
  __asm__ volatile(
      "ldr r0, =0xE000ED88\n"
      "ldr r1, [r0]\n"
      "orr r1, r1, #(0xF << 20)\n"
      "str r1, [r0]\n"
      "dsb\n"
      "isb\n"
      "b Start\n");
}

extern "C" void Start() {
  PrepareMemory();
  GuardStack();
  Register(kCcr) = Register(kCcr) | kDivideByZeroTraps;
  Register(kShcsr) = Register(kShcsr) | kMemoryBusUsageFaults;
  for (auto* constructor = _init_array_begin; constructor < _init_array_end; ++constructor) (*constructor)();
  static char command_line[256];
  CommandLine(command_line, sizeof command_line);
  Exit(Main(WithoutName(command_line)));
}

// A different stack before anything is pushed: the old one may be the cause.
extern "C" __attribute__((naked)) void Exception_Handler() {
  __asm__ volatile(
      "mrs r0, ipsr\n"
      "mov r1, sp\n"
      "ldr sp, =_exception_stack_top\n"
      "b ReportException\n");
}

// `frame`: r0-r3, r12, lr, pc, xpsr as the exception has stacked them [ARMv7-M, B1.5.6].
extern "C" void ReportException(std::uint32_t number, const std::uint32_t* frame) {
  Text text;
  text.Add("exception ").Add(number);
  text.Add(", CFSR ").AddHex(Register(kCfsr));
  if (frame >= _stack_limit && frame + 8 <= _stack_top) text.Add(", at ").AddHex(frame[6]);
  text.Add("\n");
  Print(text.c_str());
  Exit(kExitException + static_cast<int>(number));
}
