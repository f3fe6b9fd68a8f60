// The command line of the examples; nothing of OpenXR.
#pragma once

#include <string>

namespace example {

struct Options {
  std::string hand = "right";
  std::string name;  // what the runtime, and omnid's files in apps.d, see
  double seconds = 10;
};

// [--hand right|left] [--seconds S] [--name NAME]; `options.name` is at first the program's. False, with a line on
// stderr: something else was given.
bool ParseArguments(int argc, char** argv, Options& options);

}  // namespace example
