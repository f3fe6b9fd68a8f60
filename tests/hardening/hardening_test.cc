// Each program and library that we ship has the protections of compiler and linker, read from the files themselves.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/hardening/elf_hardening.h"

namespace omni::hardening {
namespace {

std::vector<std::string> Lines(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

// What CMake would install, and all else that is built of service, layer and scenes.
std::vector<std::string> OurFiles() { return Lines(OMNI_BINARY_DIR "/hardening/files.txt"); }

TEST(Hardening, EveryBinaryIsPositionIndependentWithFullRelro) {
  const std::vector<std::string> files = OurFiles();
  ASSERT_GE(files.size(), 8U);
  for (const std::string& path : files) {
    const base::Result<Hardening> file = ReadHardening(path);
    ASSERT_TRUE(file.ok()) << file.error();
    EXPECT_TRUE(file->position_independent) << path;
    EXPECT_TRUE(file->relro && file->bound_at_start) << path << ": its table of functions can be overwritten";
    EXPECT_FALSE(file->stack_executable) << path;
    EXPECT_EQ(file->is_program, path.find("/bin/") != std::string::npos) << path;
  }
}

constexpr const char* kPrints[] = {"printf", "fprintf", "snprintf", "vsnprintf", "vfprintf"};

// The compiler takes the checked variant wherever it knows the size of what is written to.
TEST(Hardening, EveryBinaryHasStackProtectorAndFortify) {
  for (const std::string& path : OurFiles()) {
    const base::Result<Hardening> file = ReadHardening(path);
    ASSERT_TRUE(file.ok()) << file.error();
    EXPECT_EQ(file->imports.count("__stack_chk_fail"), 1U) << path;
    const bool checks = std::any_of(file->imports.begin(), file->imports.end(), [](const std::string& name) {
      return name.starts_with("__") && name.ends_with("_chk");
    });
    // printf and its relatives have one for every call: plain ones belong to a library that is linked in.
    const bool prints = std::any_of(std::begin(kPrints), std::end(kPrints),
                                    [&](const char* name) { return file->imports.count(name) != 0; });
    EXPECT_TRUE(checks || !prints) << path;
    EXPECT_TRUE(checks || !(path.ends_with("/omnid") || path.ends_with("/omni") || path.ends_with(".so"))) << path;
  }
}

// Large frames step over a guard page unless each page is touched: seen in the code of the two programs that have such
// frames, and checked in the compiler flags of every file.
TEST(Hardening, ProgramsProbeLargeStackFrames) {
  for (const std::string& path : OurFiles()) {
    if (!path.ends_with("/bin/omnid") && !path.ends_with("/bin/omni")) continue;
    const base::Result<Hardening> file = ReadHardening(path);
    ASSERT_TRUE(file.ok()) << file.error();
    EXPECT_TRUE(file->probes_stack) << path;
  }
}

TEST(Hardening, EverySourceIsCompiledWithHardeningFlags) {
  std::ifstream file(OMNI_BINARY_DIR "/compile_commands.json");
  const nlohmann::json commands = nlohmann::json::parse(file, nullptr, false);
  ASSERT_TRUE(commands.is_array());
  ASSERT_GT(commands.size(), 100U);
  for (const nlohmann::json& entry : commands) {
    const std::string command = entry["command"].get<std::string>() + " ";
    for (const char* flag : {" -fstack-protector-strong ", " -fstack-clash-protection ", " -D_FORTIFY_SOURCE=2 "})
      EXPECT_NE(command.find(flag), std::string::npos) << entry["file"] << ": " << flag;
    for (const char* flag : {" -fno-stack-protector ", " -fno-stack-clash-protection ", " -no-pie ", " -O0 "})
      EXPECT_EQ(command.find(flag), std::string::npos) << entry["file"] << ": " << flag;
  }
}

}  // namespace
}  // namespace omni::hardening
