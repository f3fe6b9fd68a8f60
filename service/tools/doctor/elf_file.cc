#include "service/tools/doctor/elf_file.h"

#include <elf.h>

#include <algorithm>
#include <cstddef>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <utility>

namespace omni::tools {
namespace {

constexpr std::uintmax_t kMaxElfBytes = std::uintmax_t{1} << 28;
constexpr const char* kGlibcPrefix = "GLIBC_";
// More than any library has; a corrupted file may chain them arbitrarily.
constexpr std::size_t kMaxName = 4096;
constexpr int kMaxNeededVersions = 10'000;

// A file in memory; reads stay inside whatever its offsets are.
class ElfImage {
 public:
  explicit ElfImage(std::vector<char> bytes) : bytes_(std::move(bytes)) {}

  template <class T>
  bool Get(std::uint64_t at, T& value) const {
    if (!(at <= bytes_.size() && sizeof(T) <= bytes_.size() - at)) return false;
    std::memcpy(&value, bytes_.data() + at, sizeof(T));
    return true;
  }
  // Empty: outside, or not terminated.
  std::string Text(std::uint64_t at) const {
    if (at >= bytes_.size()) return {};
    const auto begin = bytes_.begin() + static_cast<std::ptrdiff_t>(at);
    const auto limit = begin + static_cast<std::ptrdiff_t>(std::min<std::uint64_t>(kMaxName, bytes_.size() - at));
    const auto end = std::find(begin, limit, '\0');
    return end == limit ? std::string() : std::string(begin, end);
  }
  std::uint64_t size() const { return bytes_.size(); }

 private:
  std::vector<char> bytes_;
};

std::vector<Elf64_Shdr> Sections(const ElfImage& image, const Elf64_Ehdr& header) {
  std::vector<Elf64_Shdr> sections(header.e_shnum);
  for (std::size_t i = 0; i < sections.size(); ++i) {
    if (!image.Get(header.e_shoff + i * sizeof(Elf64_Shdr), sections[i])) return {};
  }
  return sections;
}

std::vector<int> Numbers(const std::string& version) {
  std::vector<int> numbers;
  std::istringstream parts(version);
  for (std::string part; std::getline(parts, part, '.');) numbers.push_back(std::atoi(part.c_str()));
  return numbers;
}

// "2.9" < "2.34".
bool Older(const std::string& a, const std::string& b) { return Numbers(a) < Numbers(b); }

void ReadNeededVersions(const ElfImage& image, const Elf64_Shdr& section, std::uint64_t names, ElfFile& file) {
  std::uint64_t at = section.sh_offset;
  int left = kMaxNeededVersions;
  for (std::uint32_t i = 0; i < section.sh_info; ++i) {
    Elf64_Verneed need{};
    if (left-- == 0 || !image.Get(at, need)) return;
    std::uint64_t aux_at = at + need.vn_aux;
    for (int k = 0; k < need.vn_cnt; ++k) {
      Elf64_Vernaux aux{};
      if (left-- == 0 || !image.Get(aux_at, aux)) return;
      const std::string name = image.Text(names + aux.vna_name);
      if (name.rfind(kGlibcPrefix, 0) == 0) {
        const std::string version = name.substr(std::strlen(kGlibcPrefix));
        if (file.newest_glibc.empty() || Older(file.newest_glibc, version)) file.newest_glibc = version;
      }
      aux_at += aux.vna_next;
    }
    at += need.vn_next;
  }
}

void ReadExports(const ElfImage& image, const Elf64_Shdr& section, std::uint64_t names, ElfFile& file) {
  for (std::uint64_t at = 0; at + sizeof(Elf64_Sym) <= section.sh_size; at += sizeof(Elf64_Sym)) {
    Elf64_Sym symbol{};
    if (!image.Get(section.sh_offset + at, symbol)) return;
    if (symbol.st_shndx == SHN_UNDEF || symbol.st_shndx == SHN_ABS) continue;
    if (ELF64_ST_BIND(symbol.st_info) == STB_LOCAL) continue;
    if (const std::string name = image.Text(names + symbol.st_name); !name.empty()) file.exported.push_back(name);
  }
}

void ReadNeeded(const ElfImage& image, const Elf64_Shdr& section, std::uint64_t names, ElfFile& file) {
  for (std::uint64_t at = 0; at + sizeof(Elf64_Dyn) <= section.sh_size; at += sizeof(Elf64_Dyn)) {
    Elf64_Dyn entry{};
    if (!image.Get(section.sh_offset + at, entry) || entry.d_tag == DT_NULL) return;
    if (entry.d_tag == DT_NEEDED) file.needed.push_back(image.Text(names + entry.d_un.d_val));
  }
}

void ReadDynamicPart(const ElfImage& image, const Elf64_Ehdr& header, ElfFile& file) {
  const std::vector<Elf64_Shdr> sections = Sections(image, header);
  for (const Elf64_Shdr& section : sections) {
    if (section.sh_link >= sections.size()) continue;
    const std::uint64_t names = sections[section.sh_link].sh_offset;
    if (section.sh_type == SHT_GNU_verneed) ReadNeededVersions(image, section, names, file);
    if (section.sh_type == SHT_DYNSYM) ReadExports(image, section, names, file);
    if (section.sh_type == SHT_DYNAMIC) ReadNeeded(image, section, names, file);
  }
}

}  // namespace

std::string ElfFile::architecture() const {
  switch (machine) {
    case EM_X86_64:
      return bits == 64 ? "x86-64" : "x32";
    case EM_386:
      return "i386";
    case EM_AARCH64:
      return "aarch64";
    case EM_ARM:
      return "arm";
    default:
      return "machine " + std::to_string(machine);
  }
}

base::Result<ElfFile> ReadElfFile(const std::string& path) {
  std::error_code error;
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return base::Error{path + ": " + error.message()};
  if (size > kMaxElfBytes) return base::Error{path + ": larger than any library"};
  std::vector<char> bytes(size);
  std::ifstream stream(path, std::ios::binary);
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(size)))
    return base::Error{path + ": cannot be read; check its permissions"};
  const ElfImage image(std::move(bytes));
  unsigned char ident[EI_NIDENT] = {};
  Elf32_Half machine = 0;
  const bool elf = image.Get(0, ident) && std::memcmp(ident, ELFMAG, SELFMAG) == 0 && ident[EI_DATA] == ELFDATA2LSB &&
                   image.Get(offsetof(Elf32_Ehdr, e_machine), machine);
  if (!elf) return base::Error{path + ": is not a shared library"};
  ElfFile file;
  file.bytes = size;
  file.bits = ident[EI_CLASS] == ELFCLASS64 ? 64 : 32;
  file.machine = machine;
  Elf64_Ehdr header{};
  if (file.bits == 64 && image.Get(0, header)) ReadDynamicPart(image, header, file);
  return file;
}

std::string DescribeElf(const ElfFile& file) {
  const auto list = [](const std::vector<std::string>& names) {
    std::string text;
    for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
    return text.empty() ? std::string("nothing") : text;
  };
  return "size         " + std::to_string(file.bytes) + " bytes\narchitecture " + file.architecture() +
         "\nC library    glibc " + (file.newest_glibc.empty() ? "any" : file.newest_glibc + " or newer") +
         "\nneeds        " + list(file.needed) + "\nexports      " + list(file.exported) + "\n";
}

}  // namespace omni::tools
