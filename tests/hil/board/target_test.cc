// Programs that run to their end on the emulated Cortex-M7 and report by their exit status.
#include <gtest/gtest.h>

#include <cstdio>
#include <fstream>
#include <memory>
#include <set>
#include <string>

#include "firmware/board/mps2_an500/host_link.h"
#include "tests/hil/board/qemu_process.h"
#include "tests/hil/board/tools.h"

namespace omni::hil {
namespace {

using namespace firmware;

constexpr int kTimeout_ms = 1'400'000;  // it only ends what hangs

// Tests in the sources that the image was built of.
int CountTests() {
  std::ifstream list(ImagePath("mps2_tests").replace(ImagePath("mps2_tests").size() - 3, 3, "txt"));
  std::string path, line;
  int count = 0;
  while (std::getline(list, path)) {
    std::ifstream source(path);
    while (std::getline(source, line)) {
      if (line.rfind("TEST(", 0) == 0 || line.rfind("TEST_F(", 0) == 0 || line.rfind("TEST_P(", 0) == 0) ++count;
    }
  }
  return count;
}

TEST(Target, PassesTheUnitTestsOfTheHost) {
  OMNI_NEEDS_BOARD();
  const auto run = RunImage({"mps2_tests", {}}, kTimeout_ms);
  ASSERT_TRUE(run.ok()) << run.error();
  std::printf("%s", run->output.c_str());
  EXPECT_EQ(run->status, 0);
  int tests = 0, times = 0, failed = -1, left_out = 0;
  ASSERT_EQ(std::sscanf(run->output.c_str(), "%d tests, run %d times, %d failed; %d left out", &tests, &times, &failed,
                        &left_out),
            4);
  EXPECT_GT(tests, 0);
  EXPECT_EQ(tests + left_out, CountTests());
  EXPECT_EQ(failed, 0);
}

TEST(Target, ExitStatusIsTheNumberOfFailures) {
  OMNI_NEEDS_BOARD();
  const auto run = RunImage({"mps2_tests", {"self"}}, kTimeout_ms);
  ASSERT_TRUE(run.ok()) << run.error();
  EXPECT_EQ(run->status, 3) << run->output;
  EXPECT_NE(run->output.find("1 + 1 == 3 does not hold: 2 and 3"), std::string::npos) << run->output;
  for (const char* name : {"HarnessSelf.AFailedExpectationCounts", "HarnessSelf.AFailedAssertionEndsTheTest",
                           "HarnessSelfParameters.EachComesOnce/1"}) {
    EXPECT_NE(run->output.find(std::string("FAILED ") + name + "\n"), std::string::npos) << name << "\n" << run->output;
  }
  EXPECT_NE(run->output.find("4 tests, run 6 times, 3 failed; 0 left out"), std::string::npos) << run->output;
}

// An undefined instruction is a usage fault, exception 6.
TEST(Target, ExitStatusNamesTheException) {
  OMNI_NEEDS_BOARD();
  const auto run = RunImage({"mps2_tests", {"exception"}}, kTimeout_ms);
  ASSERT_TRUE(run.ok()) << run.error();
  EXPECT_EQ(run->status, board::kExitException + 6) << run->output;
  EXPECT_NE(run->output.find("exception 6, CFSR 00010000, at 0000"), std::string::npos) << run->output;
}

// Below the stack is a guard of the memory protection unit, exception 4; no data is overwritten.
TEST(Target, StackOverflowRaisesAnException) {
  OMNI_NEEDS_BOARD();
  const auto run = RunImage({"mps2_tests", {"overflow"}}, kTimeout_ms);
  ASSERT_TRUE(run.ok()) << run.error();
  EXPECT_EQ(run->status, board::kExitException + 4) << run->output;
}

// Names that the linker has put into an image.
std::set<std::string> SymbolsOf(const std::string& image) {
  const std::string command = "arm-none-eabi-nm --demangle=auto " + ImagePath(image);
  const std::unique_ptr<FILE, int (*)(FILE*)> output(::popen(command.c_str(), "r"), ::pclose);
  std::set<std::string> symbols;
  char line[4096];
  while (output != nullptr && std::fgets(line, sizeof line, output.get()) != nullptr) {
    const std::string text = line;  // "00001234 T name\n", or blanks for an address
    if (text.size() > 12) symbols.insert(text.substr(11, text.size() - 12));
  }
  return symbols;
}

// The core promises: no heap, no exceptions, no libm (whose last bits differ from the host's), no printf.
TEST(Target, FirmwareLinksNoHeapAndNoMathsLibrary) {
  OMNI_NEEDS_BOARD();
  const auto firmware = SymbolsOf("mps2_lockstep"), tests = SymbolsOf("mps2_tests");
  ASSERT_EQ(firmware.count("Reset_Handler"), 1U);
  for (const char* name : {"malloc",      "_malloc_r", "free",      "_sbrk", "operator new(unsigned int)",
                           "__cxa_throw", "printf",    "vsnprintf", "abort", "sinf",
                           "cosf",        "tanf",      "atan2f",    "sin",   "cos",
                           "tan",         "atan2",     "powf",      "pow",   "expf",
                           "exp",         "logf",      "log",       "hypot", "fmod"}) {
    EXPECT_EQ(firmware.count(name), 0U) << name;
  }
  // Where there is a heap, its names are found.
  EXPECT_EQ(tests.count("malloc"), 1U);
  EXPECT_EQ(tests.count("operator new(unsigned int)"), 1U);
}

}  // namespace
}  // namespace omni::hil
