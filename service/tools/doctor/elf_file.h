// Architecture, dependencies and exports of a shared library, read from its file without running it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::tools {

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

}  // namespace omni::tools
