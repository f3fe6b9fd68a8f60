// Runs the registered tests on the emulated board. The exit status is the number of tests that failed.
//   tests               all
//   tests self          tests of this harness: some that fail, and one that does not
//   tests exception     executes an undefined instruction; start-up ends with a status that names the exception
//   tests overflow      recurses until the stack is full: also an exception; no data are overwritten
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <set>
#include <string>

#include "firmware/board/mps2_an500/host_link.h"
#include "firmware/board/mps2_an500/semihosting.h"
#include "firmware/board/mps2_an500/start.h"

namespace testing::internal {

void Report(const char* file, int line, const std::string& text) {
  omni::firmware::board::Print((std::string(file) + ":" + std::to_string(line) + ": " + text + "\n").c_str());
}

}  // namespace testing::internal

TEST(HarnessSelf, AFailedExpectationCounts) { EXPECT_EQ(1 + 1, 3) << "on purpose"; }
TEST(HarnessSelf, AFailedAssertionEndsTheTest) {
  ASSERT_TRUE(false) << "on purpose";
  omni::firmware::board::Exit(omni::firmware::board::kExitFailuresMax);  // never comes here
}
TEST(HarnessSelf, WhatHoldsPasses) { EXPECT_LT(1, 2); }

class HarnessSelfParameters : public testing::TestWithParam<int> {};
TEST_P(HarnessSelfParameters, EachComesOnce) { EXPECT_TRUE(GetParam() == 3 || GetParam() == 5); }
INSTANTIATE_TEST_SUITE_P(Odd, HarnessSelfParameters, testing::Values(3, 4, 5));

namespace omni::firmware::board {
namespace {

using testing::Test;
using testing::internal::Registered;

bool Passes(const Registered& registered) {
  Test::fatal = false;
  Test::failures_of_this_test = 0;
  Test* const test = registered.make();
  test->SetUp();
  if (!Test::fatal) test->TestBody();
  test->TearDown();
  delete test;
  return Test::failures_of_this_test == 0;
}

// These need minutes of device time, which take longer here, or a file to compare with. The core behaves the same on
// every target: tests/hil/board/lockstep_test.cc.
const std::set<std::string> kLeftOut = {
    "FirmwareCurrent.StaysWithinHalfAPercentOver15MinutesOfHeating",
    "FirmwareCurrent.DeratesWithTemperatureWithoutTripping", "FirmwareFaultMatrix.DetectsEveryFaultAndEndsAtRest",
    "FirmwareFaultMatrix.CoversEveryFault", "FirmwareFaultMatrix.FaultsPageMatchesMeasurements"};

int RunTests(bool self) {
  for (void (*expand)() : testing::internal::Expansions()) expand();
  int run = 0, failed = 0;
  std::set<std::string> written, left_out;
  for (const Registered& test : testing::internal::Tests()) {
    if ((std::strncmp(test.suite, "HarnessSelf", 11) == 0) != self) continue;
    const std::string name = std::string(test.suite) + "." + test.written;
    if (kLeftOut.count(name) != 0) {
      left_out.insert(name);
      continue;
    }
    ++run;
    written.insert(name);
    if (Passes(test)) continue;
    ++failed;
    Print((std::string("FAILED ") + test.suite + "." + test.name + "\n").c_str());
  }
  Print((std::to_string(written.size()) + " tests, run " + std::to_string(run) + " times, " + std::to_string(failed) +
         " failed; " + std::to_string(left_out.size()) + " left out; " + std::to_string(StackUsed_bytes()) +
         " bytes of stack\n")
            .c_str());
  return std::min(failed, kExitFailuresMax);
}

// Deeper than any stack. The result depends on the frames, so that they are not optimised away.
int Deeper(volatile int* outer, int level) {
  volatile int here[64] = {};
  here[0] = *outer + level;
  return level == 0 ? here[0] : Deeper(here, level - 1) + here[0];
}

}  // namespace

int Main(const char* command_line) {
  const std::string what = command_line;
  if (what.empty()) return RunTests(false);
  if (what == "self") return RunTests(true);
  if (what == "exception") {
    __asm__ volatile("udf #0");
  }
  if (what == "overflow") {
    volatile int zero = 0;
    return Deeper(&zero, 1'000'000) == 0 ? kExitOk : kExitFailuresMax;
  }
  Print("tests: the argument is self, exception, overflow or nothing\n");
  return kExitUsage;
}

}  // namespace omni::firmware::board
