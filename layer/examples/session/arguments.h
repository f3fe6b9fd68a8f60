// The command line of the examples; nothing of OpenXR.
#pragma once

#include <optional>
#include <string>

namespace example {

struct Options {
  std::string hand = "right";
  std::string name;  // what the runtime, and omnid's files in apps.d, see
  double seconds = 10;
};

// [--hand right|left] [--seconds S] [--name NAME]; `options.name` is at first the program's. Empty: continue. Otherwise
// the exit status: 0, --help was printed; 2, something else was given, and stderr says what.
std::optional<int> ParseArguments(int argc, char** argv, Options& options);

}  // namespace example
