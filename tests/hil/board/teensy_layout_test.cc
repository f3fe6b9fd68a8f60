// Is the Teensy's image what its boot ROM and its boot loader want? No silicon here: this proves the layout, not that
// it runs (firmware/README.md).
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <sstream>

#include "firmware/board/teensy40/boot/memory_map.h"
#include "firmware/board/teensy40/chip/cpu.h"
#include "tests/hil/board/elf_file.h"
#include "tests/hil/board/intel_hex.h"
#include "tests/hil/board/tools.h"

namespace omni::hil {
namespace {

namespace fs = std::filesystem;
using namespace board;

// An image that exceeds these still links, but its growth needs a reason.
constexpr std::uint32_t kImageBudget = 128 * 1024;
constexpr std::uint32_t kDataBudget = 64 * 1024;  // .data and .bss

std::string Slurp(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::uint8_t> BytesOf(const std::string& text) { return {text.begin(), text.end()}; }

class TeensyLayout : public ::testing::Test {
 protected:
  void SetUp() override {
    if (std::string(OMNI_IMAGE_DIR).empty()) GTEST_SKIP() << "built without firmware images: run scripts/setup all";
    std::string error;
    elf_ = ReadElf(BytesOf(Slurp(ImagePath("omni_teensy40"))), error);
    ASSERT_EQ(error, "") << ImagePath("omni_teensy40");
  }

  // A word of the image as it lies in flash.
  std::uint32_t Flash(std::uint32_t address) const {
    for (const ElfSegment& segment : elf_.segments) {
      const std::uint32_t at = address - segment.load_address;
      if (address < segment.load_address || at + 4 > segment.bytes.size()) continue;
      return static_cast<std::uint32_t>(segment.bytes[at]) | static_cast<std::uint32_t>(segment.bytes[at + 1]) << 8 |
             static_cast<std::uint32_t>(segment.bytes[at + 2]) << 16 |
             static_cast<std::uint32_t>(segment.bytes[at + 3]) << 24;
    }
    ADD_FAILURE() << "nothing at " << address;
    return 0;
  }

  const ElfSection& Section(const std::string& name) const {
    static const ElfSection kNone;
    const ElfSection* section = elf_.Section(name);
    if (section == nullptr) ADD_FAILURE() << "no section " << name;
    return section == nullptr ? kNone : *section;
  }

  std::uint32_t Symbol(const std::string& name) const {
    const auto value = elf_.Symbol(name);
    if (!value) ADD_FAILURE() << "no symbol " << name;
    return value.value_or(0);
  }

  ElfFile elf_;
};

TEST_F(TeensyLayout, FlashConfigurationIsFirst) {
  EXPECT_EQ(Flash(kFlashBase), 0x42464346U) << "FCFB";
  EXPECT_EQ(Flash(kFlashBase + 4) >> 24, 0x56U) << "V";
  EXPECT_EQ(Flash(kFlashBase + 0x44) & 0xFF, 1U) << "serial NOR";
  EXPECT_EQ(Flash(kFlashBase + 0x44) >> 8 & 0xFF, 4U) << "four pads";
  EXPECT_EQ(Flash(kFlashBase + 0x50), kFlashSize);
  // Read: command EBh on one pad, 24 address bits on four; a mode byte that asks for no continuous read; then data.
  EXPECT_EQ(Flash(kFlashBase + 0x80), 0x0A1804EBU);
  EXPECT_EQ(Flash(kFlashBase + 0x84), 0x32041E00U);
  EXPECT_EQ(Flash(kFlashBase + 0x88), 0x00002604U);
  EXPECT_EQ(Flash(kFlashBase + 0x1C0), 256U) << "page";
  EXPECT_EQ(Flash(kFlashBase + 0x1C4), 4096U) << "sector";
}

TEST_F(TeensyLayout, ImageVectorTablePointsToStartUp) {
  EXPECT_EQ(Flash(kIvtAddress), 0x432000D1U);
  const std::uint32_t entry = Flash(kIvtAddress + 4);
  EXPECT_EQ(entry & 1U, 1U) << "Thumb";
  EXPECT_EQ(entry, elf_.entry);
  EXPECT_EQ(entry, Symbol("ResetHandler"));
  const ElfSection& startup = Section(".startup");
  EXPECT_GE(entry, startup.address);
  EXPECT_LT(entry, startup.address + startup.size);
  EXPECT_GE(startup.address, kFlashBase + 0x1400) << "behind the headers";
  EXPECT_EQ(Flash(kIvtAddress + 12), 0U) << "no device configuration data";
  EXPECT_EQ(Flash(kIvtAddress + 16), kIvtAddress + 0x20) << "boot data";
  EXPECT_EQ(Flash(kIvtAddress + 20), kIvtAddress) << "itself";
  EXPECT_EQ(Flash(kIvtAddress + 24), 0U) << "not signed";
}

TEST_F(TeensyLayout, BootDataCoversTheWholeImage) {
  std::uint32_t end = 0;
  for (const ElfSegment& segment : elf_.segments) {
    if (!segment.bytes.empty())
      end = std::max(end, segment.load_address + static_cast<std::uint32_t>(segment.bytes.size()));
  }
  EXPECT_EQ(Flash(kIvtAddress + 0x20), kFlashBase);
  EXPECT_EQ(Flash(kIvtAddress + 0x24), end - kFlashBase);
  EXPECT_EQ(Flash(kIvtAddress + 0x28), 0U) << "no plug-in";
  EXPECT_LE(end - kFlashBase, kFlashUsable);
  EXPECT_LE(end - kFlashBase, kImageBudget);
  std::printf("image %u of %u bytes of flash\n", end - kFlashBase, kFlashUsable);
}

TEST_F(TeensyLayout, VectorTableIsCompleteAndPointsToCode) {
  const ElfSection& code = Section(".itcm");
  ASSERT_EQ(code.address, kNullTrapSize) << "first in its memory, aligned to more than its size";
  ASSERT_GE(code.bytes.size(), 4U * kVectors);
  const auto vector = [&](int number) {
    return Flash(Symbol("__itcm_load") + 4U * static_cast<std::uint32_t>(number));
  };
  EXPECT_EQ(vector(0), Symbol("__stack_top"));
  EXPECT_EQ(vector(1), Symbol("ResetHandler"));
  const std::uint32_t fault = Symbol("FaultEntry");
  for (int number = 2; number < kVectors; ++number) {
    const std::uint32_t handler = vector(number);
    EXPECT_EQ(handler & 1U, 1U) << number;
    EXPECT_TRUE(handler >= code.address && handler < code.address + code.size) << number;
    const bool used = number == kCoreVectors + static_cast<int>(Irq::kLpi2c1) ||
                      number == kCoreVectors + static_cast<int>(Irq::kUsb1) ||
                      number == kCoreVectors + static_cast<int>(Irq::kPit);
    EXPECT_EQ(handler == fault, !used) << number << ": unused interrupts brake and reset";
  }
  EXPECT_EQ(vector(kCoreVectors + static_cast<int>(Irq::kPit)), Symbol("OnControlStep"));
}

TEST_F(TeensyLayout, SectionsLieInTheirMemoriesWithoutOverlap) {
  struct Memory {
    const char* section;
    std::uint32_t base, size;
  };
  const Memory kPlaces[] = {
      {".headers", kFlashBase, kFlashUsable},
      {".startup", kFlashBase, kFlashUsable},
      {".itcm", kItcmBase + kNullTrapSize, kItcmSize - kNullTrapSize},
      {".stack", kDtcmBase, kStackSize},
      {".data", kDtcmBase + kStackSize, kDtcmSize - kStackSize},
      {".bss", kDtcmBase + kStackSize, kDtcmSize - kStackSize},
      {".shared", kOcramBase + kOcramOfRom, kOcramSize - kOcramOfRom - kRetainedSize},
      {".retained", kRetainedAddress, kRetainedSize},
  };
  std::vector<const ElfSection*> placed;
  for (const Memory& place : kPlaces) {
    const ElfSection& section = Section(place.section);
    EXPECT_GE(section.address, place.base) << place.section;
    EXPECT_LE(section.address + section.size, place.base + place.size) << place.section;
    placed.push_back(&section);
  }
  for (const ElfSection& section : elf_.sections) {
    if (!section.allocated) continue;
    const auto is_it = [&](const ElfSection* place) { return place->name == section.name; };
    EXPECT_EQ(std::count_if(placed.begin(), placed.end(), is_it), 1) << section.name << " has no place";
  }
  for (const ElfSection* a : placed) {
    for (const ElfSection* b : placed) {
      const bool apart = a == b || a->address + a->size <= b->address || b->address + b->size <= a->address;
      EXPECT_TRUE(apart) << a->name << " and " << b->name;
    }
  }
}

TEST_F(TeensyLayout, MemoriesFitTheirBudgets) {
  EXPECT_EQ(Section(".stack").size, kStackSize);
  EXPECT_EQ(Symbol("__stack_top") % 8, 0U) << "AAPCS";
  EXPECT_EQ(Symbol("__stack_bottom"), kDtcmBase) << "an overflow leaves the memory";
  const std::uint32_t data = Section(".data").size + Section(".bss").size;
  EXPECT_LE(data, kDataBudget);
  EXPECT_FALSE(Section(".stack").stored || Section(".bss").stored || Section(".shared").stored ||
               Section(".retained").stored);
  EXPECT_EQ(Symbol("__shared_begin") % 2048, 0U) << "USB queue heads, RM ENDPOINTLISTADDR";
  std::printf("code %u of %u, data %u of %u, shared %u bytes\n", Section(".itcm").size, kItcmSize - kNullTrapSize, data,
              kDtcmSize - kStackSize, Section(".shared").size);
}

// The compiler's own frame sizes. No function recurses or sizes its frame at run time, so what is on the stack at once
// is at most every frame; twice that allows for functions that the main loop and an interrupt share.
TEST_F(TeensyLayout, StackHoldsTwiceTheSumOfAllFrames) {
  constexpr std::uint32_t kLevels = 4, kExceptionFrame = 112;  // with FPU registers and padding [ARM B1.5.7]
  std::uint32_t sum = 0, functions = 0;
  const fs::path cross = fs::path(OMNI_BINARY_DIR) / "cross";
  for (const char* target : {"teensy40/CMakeFiles/teensy40.dir", "teensy40/CMakeFiles/omni_teensy40.dir",
                             "CMakeFiles/firmware_core.dir", "CMakeFiles/firmware_wire.dir"}) {
    for (const auto& entry : fs::recursive_directory_iterator(cross / target)) {
      if (entry.path().extension() != ".su") continue;
      std::istringstream lines(Slurp(entry.path().string()));
      std::string line;
      while (std::getline(lines, line)) {  // "place:function \t bytes \t static"
        const std::size_t first = line.find('\t'), second = line.find('\t', first + 1);
        ASSERT_NE(second, std::string::npos) << line;
        EXPECT_EQ(line.substr(second + 1), "static") << line;
        sum += static_cast<std::uint32_t>(std::stoul(line.substr(first + 1, second - first - 1)));
        ++functions;
      }
    }
  }
  EXPECT_GT(functions, 100U);
  EXPECT_LE(2 * sum + kLevels * kExceptionFrame, kStackSize);
  std::printf("%u functions, all frames together %u bytes, stack %u\n", functions, sum, kStackSize);
}

TEST_F(TeensyLayout, LinksNoHeapAndNoMathsLibrary) {
  ASSERT_TRUE(elf_.Symbol("main").has_value());
  for (const char* name : {"malloc",
                           "_malloc_r",
                           "free",
                           "_sbrk",
                           "_Znwj",
                           "_Znaj",
                           "_ZdlPv",
                           "__cxa_throw",
                           "__cxa_guard_acquire",
                           "_Unwind_RaiseException",
                           "printf",
                           "abort",
                           "exit",
                           "sinf",
                           "cosf",
                           "tanf",
                           "atan2f",
                           "sin",
                           "cos",
                           "tan",
                           "atan2",
                           "powf",
                           "pow",
                           "expf",
                           "exp",
                           "logf",
                           "log",
                           "hypot",
                           "fmod"}) {
    EXPECT_FALSE(elf_.Symbol(name).has_value()) << name;
  }
}

// What the loader writes is what the linker made.
TEST_F(TeensyLayout, HexFileMatchesTheElfImage) {
  std::string error;
  const std::string path = fs::path(ImagePath("omni_teensy40")).replace_extension(".hex").string();
  const auto hex = ReadIntelHex(Slurp(path), error);
  ASSERT_EQ(error, "") << path;
  std::size_t count = 0, wrong = 0;
  for (const ElfSegment& segment : elf_.segments) {
    for (std::uint32_t i = 0; i < segment.bytes.size(); ++i, ++count) {
      const auto found = hex.find(segment.load_address + i);
      if (found == hex.end() || found->second != segment.bytes[i]) ++wrong;
    }
  }
  EXPECT_EQ(wrong, 0U);
  // Gaps between sections of a segment are in the ELF only.
  EXPECT_LE(hex.size(), count);
  ASSERT_FALSE(hex.empty());
  EXPECT_EQ(hex.begin()->first, kFlashBase);
  EXPECT_LT(hex.rbegin()->first, kFlashBase + kFlashUsable);
}

// The readers themselves: a damaged file is no image.
TEST(IntelHex, RejectsDamagedFiles) {
  const std::string good = ":0200000460009A\n:0400000001020304F2\n:00000001FF\n";
  std::string error;
  const auto memory = ReadIntelHex(good, error);
  EXPECT_EQ(error, "");
  ASSERT_EQ(memory.size(), 4U);
  EXPECT_EQ(memory.at(0x60000003), 4);
  for (const auto& [from, to] : {std::pair{"F2", "F3"},
                                 {":04", ":05"},
                                 {":00000001FF\n", ""},
                                 {"010203", "01020"},
                                 {":00000001FF", ":0400000001020304F2\n:00000001FF"}}) {
    std::string bad = good;
    bad.replace(bad.find(from), std::string(from).size(), to);
    ReadIntelHex(bad, error);
    EXPECT_NE(error, "") << bad;
  }
}

TEST(ElfFile, RejectsTruncatedFiles) {
  if (std::string(OMNI_IMAGE_DIR).empty()) GTEST_SKIP() << "built without firmware images: run scripts/setup all";
  std::vector<std::uint8_t> bytes = BytesOf(Slurp(ImagePath("omni_teensy40")));
  std::string error;
  ASSERT_GT(bytes.size(), 1000U);
  for (const std::size_t size : {std::size_t{0}, std::size_t{3}, std::size_t{40}, bytes.size() / 2}) {
    ReadElf({bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(size)}, error);
    EXPECT_NE(error, "") << size;
  }
  bytes[0] = 0;
  ReadElf(bytes, error);
  EXPECT_NE(error, "");
}

}  // namespace
}  // namespace omni::hil
