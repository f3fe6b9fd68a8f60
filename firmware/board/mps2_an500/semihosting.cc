#include "firmware/board/mps2_an500/semihosting.h"

#include <cstring>

namespace omni::firmware::board {
namespace {

// Section 6: operation numbers.
enum class Operation : std::uint32_t {
  kOpen = 0x01,
  kClose = 0x02,
  kWrite0 = 0x04,
  kWrite = 0x05,
  kRead = 0x06,
  kGetCommandLine = 0x15,
  kExitExtended = 0x20
};
constexpr std::uint32_t kApplicationExit = 0x20026;  // ADP_Stopped_ApplicationExit

// Section 3: operation in r0, its block of arguments in r1, result in r0; BKPT 0xAB on M profiles.
std::int32_t Call(Operation operation, const void* argument) noexcept {
  register std::uint32_t r0 __asm__("r0") = static_cast<std::uint32_t>(operation);
  register const void* r1 __asm__("r1") = argument;
  __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return static_cast<std::int32_t>(r0);
}

std::uint32_t Word(const void* pointer) noexcept {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(pointer));
}

}  // namespace

int OpenFile(const char* name, FileMode mode) noexcept {
  const std::uint32_t block[] = {Word(name), static_cast<std::uint32_t>(mode), std::strlen(name)};
  return Call(Operation::kOpen, block);
}

void CloseFile(int file) noexcept {
  const std::uint32_t block[] = {static_cast<std::uint32_t>(file)};
  Call(Operation::kClose, block);
}

bool ReadAll(int file, void* data, std::size_t size) noexcept {
  auto* at = static_cast<std::uint8_t*>(data);
  while (size > 0) {
    const std::uint32_t block[] = {static_cast<std::uint32_t>(file), Word(at), size};
    const std::int32_t missing = Call(Operation::kRead, block);
    // The result is the number of bytes that are missing: all of them at the end of the file, < 0 after an error.
    if (missing < 0 || static_cast<std::size_t>(missing) >= size) return false;
    at += size - static_cast<std::size_t>(missing);
    size = static_cast<std::size_t>(missing);
  }
  return true;
}

bool WriteAll(int file, const void* data, std::size_t size) noexcept {
  const auto* at = static_cast<const std::uint8_t*>(data);
  while (size > 0) {
    const std::uint32_t block[] = {static_cast<std::uint32_t>(file), Word(at), size};
    const std::int32_t missing = Call(Operation::kWrite, block);
    if (missing < 0 || static_cast<std::size_t>(missing) >= size) return false;
    at += size - static_cast<std::size_t>(missing);
    size = static_cast<std::size_t>(missing);
  }
  return true;
}

void Print(const char* text) noexcept { Call(Operation::kWrite0, text); }

void CommandLine(char* text, std::size_t capacity) noexcept {
  if (capacity == 0) return;
  text[0] = '\0';
  std::uint32_t block[] = {Word(text), capacity};
  if (Call(Operation::kGetCommandLine, block) != 0) text[0] = '\0';
}

void Exit(int status) noexcept {
  const std::uint32_t block[] = {kApplicationExit, static_cast<std::uint32_t>(status)};
  Call(Operation::kExitExtended, block);
  for (;;) {  // in case the emulator refuses
  }
}

}  // namespace omni::firmware::board
