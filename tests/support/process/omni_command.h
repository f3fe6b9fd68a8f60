// `omni` in this process, and its output.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "service/tools/common/command_line.h"

namespace omni::test {

struct Outcome {
  int status = -1;
  std::string out, err;
};

// `words` follow the program's name.
inline Outcome RunOmni(const std::vector<std::string>& words) {
  std::vector<const char*> argv{"omni"};
  for (const std::string& word : words) argv.push_back(word.c_str());
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Outcome outcome;
  outcome.status = tools::RunCommandLine(static_cast<int>(argv.size()), argv.data());
  outcome.out = testing::internal::GetCapturedStdout();
  outcome.err = testing::internal::GetCapturedStderr();
  return outcome;
}

}  // namespace omni::test
