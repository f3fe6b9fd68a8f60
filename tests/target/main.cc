// Runs the registered tests on the emulated board. The exit status is the number of tests that failed.
//   tests               all
//   tests self          what this harness must notice: two tests that fail, one that does not
//   tests exception     executes an undefined instruction; start-up ends with a status that names the exception
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <string>

#include "firmware/board/mps2_an500/exit_codes.h"
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

int RunTests(bool self) {
  int run = 0, failed = 0;
  for (const Registered* test = testing::internal::first; test != nullptr; test = test->next) {
    if ((std::strcmp(test->suite, "HarnessSelf") == 0) != self) continue;
    ++run;
    if (Passes(*test)) continue;
    ++failed;
    Print((std::string("FAILED ") + test->suite + "." + test->name + "\n").c_str());
  }
  Print((std::to_string(run) + " tests, " + std::to_string(failed) + " failed, " + std::to_string(StackUsed_bytes()) +
         " bytes of stack\n")
            .c_str());
  return std::min(failed, kExitFailuresMax);
}

}  // namespace

int Main(const char* command_line) {
  const std::string what = command_line;
  if (what.empty()) return RunTests(false);
  if (what == "self") return RunTests(true);
  if (what == "exception") {
    __asm__ volatile("udf #0");
  }
  Print("tests: the argument is self, exception or nothing\n");
  return kExitUsage;
}

}  // namespace omni::firmware::board
