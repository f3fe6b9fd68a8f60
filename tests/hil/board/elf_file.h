// A 32-bit little-endian ELF file, limited to what checks of a firmware image's layout need [ELF-32, TIS 1.2].
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace omni::hil {

struct ElfSection {
  std::string name;
  std::uint32_t address = 0, size = 0;
  bool allocated = false;  // takes memory on the target
  bool stored = false;     // and has bytes in the file
  std::vector<std::uint8_t> bytes;
};

// A piece of the image in flash: where its bytes are stored, and where they run.
struct ElfSegment {
  std::uint32_t load_address = 0, run_address = 0, memory_size = 0;
  std::vector<std::uint8_t> bytes;
};

struct ElfFile {
  std::uint32_t entry = 0;
  std::vector<ElfSection> sections;
  std::vector<ElfSegment> segments;  // of type LOAD
  std::map<std::string, std::uint32_t> symbols;

  const ElfSection* Section(const std::string& name) const;
  std::optional<std::uint32_t> Symbol(const std::string& name) const;
};

// Empty `error`: success. Otherwise the first error found.
ElfFile ReadElf(const std::vector<std::uint8_t>& bytes, std::string& error);

}  // namespace omni::hil
