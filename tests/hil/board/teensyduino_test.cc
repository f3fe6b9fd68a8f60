// The port for PlatformIO cannot be built here: its list of sources is compared with what the cross build compiles
// against a stub of Teensyduino.
#include <fnmatch.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "tests/hil/board/elf_file.h"
#include "tests/hil/board/tools.h"

namespace omni::hil {
namespace {

namespace fs = std::filesystem;

const fs::path kPort = fs::path(OMNI_SOURCE_DIR) / "firmware/board/teensyduino";

// Keys of platformio.ini; a value that continues on indented lines is one text.
std::map<std::string, std::string> ReadIni(const fs::path& path) {
  std::map<std::string, std::string> values;
  std::ifstream file(path);
  std::string line, key;
  while (std::getline(file, line)) {
    if (line.empty() || line[0] == ';' || line[0] == '[') continue;
    const std::size_t equals = line.find(" =");
    if (line[0] == ' ') {
      values[key] += " " + line;
    } else if (equals != std::string::npos) {
      key = line.substr(0, equals);
      values[key] = line.substr(equals + 2);
    }
  }
  return values;
}

std::string Trimmed(const std::string& text) {
  const std::size_t begin = text.find_first_not_of(' ');
  return begin == std::string::npos ? "" : text.substr(begin, text.find_last_not_of(' ') - begin + 1);
}

// "+<pattern>" takes, "-<pattern>" leaves out, in order [PlatformIO, build_src_filter].
std::set<std::string> Selected(const std::string& filter) {
  const fs::path root = OMNI_SOURCE_DIR;
  std::set<std::string> selected;
  std::istringstream words(filter);
  std::string word;
  while (words >> word) {
    const std::string pattern = word.substr(2, word.size() - 3);
    for (const auto& entry : fs::recursive_directory_iterator(root / "firmware")) {
      const std::string path = fs::relative(entry.path(), root).generic_string();
      if (!entry.is_regular_file() || ::fnmatch(pattern.c_str(), path.c_str(), pattern == "*" ? 0 : FNM_PATHNAME) != 0)
        continue;
      if (word[0] == '+') selected.insert(path);
      if (word[0] == '-') selected.erase(path);
    }
  }
  return selected;
}

TEST(Teensyduino, PlatformioIniNamesBoardAndFlags) {
  auto ini = ReadIni(kPort / "platformio.ini");
  EXPECT_EQ(Trimmed(ini["platform"]), "teensy");
  EXPECT_EQ(Trimmed(ini["board"]), "teensy40");
  EXPECT_EQ(Trimmed(ini["framework"]), "arduino");
  EXPECT_TRUE(fs::equivalent(kPort / Trimmed(ini["src_dir"]), OMNI_SOURCE_DIR));
  // The same arithmetic as everywhere, and a USB port that is ours.
  for (const char* flag : {"-ffp-contract=off", "-fno-math-errno", "-std=gnu++17", "-D USB_DISABLED"}) {
    EXPECT_NE(ini["build_flags"].find(flag), std::string::npos) << flag;
  }
}

TEST(Teensyduino, SourceFilterMatchesTheCompileCheck) {
  if (std::string(OMNI_IMAGE_DIR).empty()) GTEST_SKIP() << "built without firmware images: run scripts/setup all";
  std::ifstream list(fs::path(OMNI_IMAGE_DIR) / "teensyduino_check.txt");
  std::set<std::string> checked;
  for (std::string line; std::getline(list, line);)
    checked.insert(fs::relative(line, OMNI_SOURCE_DIR).generic_string());
  ASSERT_GT(checked.size(), 20U);
  EXPECT_EQ(Selected(ReadIni(kPort / "platformio.ini")["build_src_filter"]), checked);
}

TEST(Teensyduino, CheckLinksTheSketch) {
  if (std::string(OMNI_IMAGE_DIR).empty()) GTEST_SKIP() << "built without firmware images: run scripts/setup all";
  std::ifstream file(ImagePath("teensyduino_check"), std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(file), {}};
  std::string error;
  const ElfFile elf = ReadElf({bytes.begin(), bytes.end()}, error);
  ASSERT_EQ(error, "");
  for (const char* name : {"_Z5setupv", "_Z4loopv", "_ZN4omni8firmware4Core4StepERKNS0_6InputsERNS0_7OutputsE"}) {
    EXPECT_TRUE(elf.Symbol(name).has_value()) << name;
  }
  // Start-up code of the other port would fight Teensyduino's.
  for (const char* name : {"StartUp", "FaultEntry", "main"}) EXPECT_FALSE(elf.Symbol(name).has_value()) << name;
}

}  // namespace
}  // namespace omni::hil
