// External tools of tests with an emulated board, and the message when they are missing.
#pragma once

#include <string>

namespace omni::hil {

// Path of an image of this build ("mps2_lockstep"); it may be missing.
std::string ImagePath(const std::string& name);

// The program in PATH; empty: not there.
std::string FindProgram(const std::string& name);

// Why boards cannot be emulated here; empty: they can. Only tools that are not installed are a reason: when the cross
// compiler is there, a missing image is a failure.
std::string NoBoardReason();

}  // namespace omni::hil

// For the first line of a test.
#define OMNI_NEEDS_BOARD()                                                                                \
  do {                                                                                                    \
    if (const std::string reason = ::omni::hil::NoBoardReason(); !reason.empty()) GTEST_SKIP() << reason; \
  } while (false)
