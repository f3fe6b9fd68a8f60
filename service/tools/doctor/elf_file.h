// Shared libraries, examined as files and as the OpenXR loader does.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::tools {

// Architecture, dependencies and exports of a shared library, read from its file without running it.
struct ElfFile {
  std::uint64_t bytes = 0;
  int bits = 0;               // 32 or 64
  std::uint16_t machine = 0;  // e_machine
  // The rest is read from 64-bit files only.
  std::vector<std::string> needed;    // DT_NEEDED: libraries that must be there
  std::vector<std::string> exported;  // defined dynamic symbols
  std::string newest_glibc;           // the oldest C library that this one works with: "2.34"; empty: any

  // "x86-64", "i386", "aarch64", "arm", else "machine N".
  std::string architecture() const;
};

// Error: not readable, or no ELF file of this machine's byte order; names the file.
base::Result<ElfFile> ReadElfFile(const std::string& path);

// The contents of an ElfFile as lines of text.
std::string DescribeElf(const ElfFile& file);

// Whether a shared library can be opened and exports a function, checked as the OpenXR loader does.

// Empty: both hold. The library is opened in this process and closed again.
std::string LibraryProblem(const std::string& library, const std::string& function);

}  // namespace omni::tools
