// The interface between start-up code and the program.
#pragma once

#include <cstdint>

namespace omni::firmware::board {

// The program. `command_line`: the words after the program's name. The result is the exit status.
int Main(const char* command_line);

// Deepest use of the stack so far, in bytes: start-up has painted it.
std::uint32_t StackUsed_bytes() noexcept;
std::uint32_t StackSize_bytes() noexcept;

// Resets the whole machine [ARMv7-M, B3.2.6]. Only memory in section .noinit keeps its content.
[[noreturn]] void ResetMachine() noexcept;

}  // namespace omni::firmware::board
