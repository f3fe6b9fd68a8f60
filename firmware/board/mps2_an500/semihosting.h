// Files, console and exit status of the host that runs the emulator [Arm, "Semihosting for AArch32 and AArch64", 2.0].
// The caller stops until the host has answered. Without an emulator or debugger the first call is a fault.
#pragma once

#include <cstddef>
#include <cstdint>

namespace omni::firmware::board {

enum class FileMode : std::uint32_t { kRead = 1, kWrite = 5 };  // "rb", "wb" [section 6.13]

// Handle of a file in the emulator's working directory; < 0: cannot be opened. Opening a FIFO waits for its other end.
int OpenFile(const char* name, FileMode mode) noexcept;
void CloseFile(int file) noexcept;

// All bytes, in as many calls as needed. False: the file has ended, or its reader is gone.
bool ReadAll(int file, void* data, std::size_t size) noexcept;
bool WriteAll(int file, const void* data, std::size_t size) noexcept;

// To the emulator's console (its standard error).
void Print(const char* text) noexcept;

// Words of `-semihosting-config arg=...`, joined by spaces; empty: none, or they do not fit.
void CommandLine(char* text, std::size_t capacity) noexcept;

// Ends the emulator with this exit status.
[[noreturn]] void Exit(int status) noexcept;

}  // namespace omni::firmware::board
