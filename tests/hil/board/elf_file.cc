#include "tests/hil/board/elf_file.h"

#include <algorithm>

namespace omni::hil {
namespace {

constexpr std::uint32_t kLoad = 1, kSymbolTable = 2, kNoBits = 8, kAllocated = 2;

class Reader {
 public:
  Reader(const std::vector<std::uint8_t>& bytes, std::string& error) : bytes_(bytes), error_(error) {}

  std::uint32_t U32(std::size_t at) {
    return static_cast<std::uint32_t>(U16(at)) | static_cast<std::uint32_t>(U16(at + 2)) << 16;
  }
  std::uint16_t U16(std::size_t at) {
    if (!Has(at, 2)) return 0;
    return static_cast<std::uint16_t>(bytes_[at] | bytes_[at + 1] << 8);
  }
  std::vector<std::uint8_t> Bytes(std::size_t at, std::size_t size) {
    if (!Has(at, size)) return {};
    return {bytes_.begin() + static_cast<std::ptrdiff_t>(at), bytes_.begin() + static_cast<std::ptrdiff_t>(at + size)};
  }
  std::string Text(std::size_t at) {
    std::string text;
    while (Has(at, 1) && bytes_[at] != 0) text += static_cast<char>(bytes_[at++]);
    return text;
  }
  bool Has(std::size_t at, std::size_t size) {
    if (at <= bytes_.size() && size <= bytes_.size() - at) return true;
    if (error_.empty())
      error_ = "ends at byte " + std::to_string(bytes_.size()) + ", needs " + std::to_string(at + size);
    return false;
  }

 private:
  const std::vector<std::uint8_t>& bytes_;
  std::string& error_;
};

struct SectionHeader {
  std::uint32_t name, type, flags, address, offset, size, link;
};

SectionHeader HeaderAt(Reader& in, std::size_t at) {
  return {in.U32(at),      in.U32(at + 4),  in.U32(at + 8), in.U32(at + 12),
          in.U32(at + 16), in.U32(at + 20), in.U32(at + 24)};
}

std::vector<SectionHeader> Headers(Reader& in) {
  std::vector<SectionHeader> headers;
  const std::size_t offset = in.U32(32), stride = in.U16(46), count = in.U16(48);
  for (std::size_t i = 0; i < count; ++i) headers.push_back(HeaderAt(in, offset + i * stride));
  return headers;
}

void ReadSections(Reader& in, const std::vector<SectionHeader>& headers, ElfFile& elf) {
  const std::size_t names = in.U16(50);
  if (names >= headers.size()) return;
  for (const SectionHeader& header : headers) {
    ElfSection section{in.Text(headers[names].offset + header.name), header.address, header.size, false, false, {}};
    section.allocated = (header.flags & kAllocated) != 0 && header.size != 0;
    section.stored = section.allocated && header.type != kNoBits;
    if (section.stored) section.bytes = in.Bytes(header.offset, header.size);
    elf.sections.push_back(section);
  }
}

void ReadSymbols(Reader& in, const std::vector<SectionHeader>& headers, ElfFile& elf) {
  for (const SectionHeader& table : headers) {
    if (table.type != kSymbolTable || table.link >= headers.size()) continue;
    for (std::size_t at = table.offset; at + 16 <= table.offset + table.size; at += 16) {
      const std::string name = in.Text(headers[table.link].offset + in.U32(at));
      if (!name.empty()) elf.symbols[name] = in.U32(at + 4);
    }
  }
}

void ReadSegments(Reader& in, ElfFile& elf) {
  const std::size_t offset = in.U32(28), stride = in.U16(42), count = in.U16(44);
  for (std::size_t i = 0; i < count; ++i) {
    const std::size_t at = offset + i * stride;
    if (in.U32(at) != kLoad) continue;
    ElfSegment segment;
    segment.run_address = in.U32(at + 8);
    segment.load_address = in.U32(at + 12);
    segment.bytes = in.Bytes(in.U32(at + 4), in.U32(at + 16));
    segment.memory_size = in.U32(at + 20);
    elf.segments.push_back(segment);
  }
}

}  // namespace

const ElfSection* ElfFile::Section(const std::string& name) const {
  const auto found =
      std::find_if(sections.begin(), sections.end(), [&](const ElfSection& s) { return s.name == name; });
  return found == sections.end() ? nullptr : &*found;
}

std::optional<std::uint32_t> ElfFile::Symbol(const std::string& name) const {
  const auto found = symbols.find(name);
  return found == symbols.end() ? std::nullopt : std::optional<std::uint32_t>(found->second);
}

ElfFile ReadElf(const std::vector<std::uint8_t>& bytes, std::string& error) {
  ElfFile elf;
  error.clear();
  Reader in(bytes, error);
  if (in.U32(0) != 0x464C457F || in.U16(4) != 0x0101) {
    error = "no 32-bit little-endian ELF file";
    return elf;
  }
  elf.entry = in.U32(24);
  const std::vector<SectionHeader> headers = Headers(in);
  ReadSections(in, headers, elf);
  ReadSymbols(in, headers, elf);
  ReadSegments(in, elf);
  return elf;
}

}  // namespace omni::hil
