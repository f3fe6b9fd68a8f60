#include "tests/hardening/elf_hardening.h"

#include <elf.h>

#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "service/base/files/whole_file.h"

namespace omni::hardening {
namespace {

constexpr std::size_t kMaxBytes = 256 << 20;
// A page of the stack is taken and touched before the next one: sub $0x1000,%rsp; orq $0,(%rsp).
constexpr std::string_view kProbe("\x48\x81\xec\x00\x10\x00\x00\x48\x83\x0c\x24\x00", 12);

// 64-bit files of this machine's byte order. Whatever is beyond the end reads as zeros.
class Reader {
 public:
  explicit Reader(const std::string& bytes) : bytes_(bytes) {}

  template <class T>
  T At(std::uint64_t offset) const {
    T value{};
    if (offset <= bytes_.size() && sizeof value <= bytes_.size() - offset)
      std::memcpy(&value, bytes_.data() + offset, sizeof value);
    return value;
  }

  template <class T>
  std::vector<T> List(std::uint64_t offset, std::uint64_t bytes) const {
    std::vector<T> list;
    for (std::uint64_t at = 0; at + sizeof(T) <= bytes && list.size() < 1'000'000; at += sizeof(T))
      list.push_back(At<T>(offset + at));
    return list;
  }

  std::string Name(std::uint64_t offset) const {
    return offset < bytes_.size() ? std::string(bytes_.data() + offset) : std::string();
  }

  std::string_view Bytes(std::uint64_t offset, std::uint64_t count) const {
    return offset < bytes_.size() ? std::string_view(bytes_).substr(offset, count) : std::string_view();
  }

 private:
  const std::string& bytes_;
};

void ReadSegments(const Reader& file, const Elf64_Ehdr& header, Hardening& read) {
  for (const auto& segment : file.List<Elf64_Phdr>(header.e_phoff, header.e_phnum * sizeof(Elf64_Phdr))) {
    if (segment.p_type == PT_INTERP) read.is_program = true;
    if (segment.p_type == PT_GNU_RELRO) read.relro = true;
    if (segment.p_type == PT_GNU_STACK) read.stack_executable = (segment.p_flags & PF_X) != 0;
    if (segment.p_type == PT_LOAD && (segment.p_flags & PF_X) != 0 &&
        file.Bytes(segment.p_offset, segment.p_filesz).find(kProbe) != std::string_view::npos) {
      read.probes_stack = true;
    }
    if (segment.p_type != PT_DYNAMIC) continue;
    for (const auto& entry : file.List<Elf64_Dyn>(segment.p_offset, segment.p_filesz)) {
      if (entry.d_tag == DT_FLAGS && (entry.d_un.d_val & DF_BIND_NOW) != 0) read.bound_at_start = true;
      if (entry.d_tag == DT_FLAGS_1 && (entry.d_un.d_val & DF_1_NOW) != 0) read.bound_at_start = true;
    }
  }
}

void ReadImports(const Reader& file, const Elf64_Ehdr& header, Hardening& read) {
  const auto sections = file.List<Elf64_Shdr>(header.e_shoff, header.e_shnum * sizeof(Elf64_Shdr));
  for (const Elf64_Shdr& section : sections) {
    if (section.sh_type != SHT_DYNSYM || section.sh_link >= sections.size()) continue;
    const Elf64_Shdr& names = sections[section.sh_link];
    for (const auto& symbol : file.List<Elf64_Sym>(section.sh_offset, section.sh_size)) {
      if (symbol.st_shndx == SHN_UNDEF) read.imports.insert(file.Name(names.sh_offset + symbol.st_name));
    }
  }
}

}  // namespace

base::Result<Hardening> ReadHardening(const std::string& path) {
  const base::Result<std::string> bytes = base::ReadFile(path, kMaxBytes);
  if (!bytes.ok()) return base::Error{bytes.error()};
  const Reader file(*bytes);
  const auto header = file.At<Elf64_Ehdr>(0);
  if (std::memcmp(header.e_ident, ELFMAG, SELFMAG) != 0 || header.e_ident[EI_CLASS] != ELFCLASS64)
    return base::Error{path + ": is no 64-bit ELF file"};
  Hardening read;
  read.position_independent = header.e_type == ET_DYN;
  ReadSegments(file, header, read);
  ReadImports(file, header, read);
  return read;
}

}  // namespace omni::hardening
