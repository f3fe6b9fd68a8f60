#include "layer/examples/session/arguments.h"

#include <cstdio>
#include <cstdlib>

namespace example {
namespace {

bool Parse(int argc, char** argv, Options& options) {
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string key = argv[i];
    const char* value = argv[i + 1];
    if (key == "--hand") {
      options.hand = value;
    } else if (key == "--name") {
      options.name = value;
    } else if (key == "--seconds") {
      options.seconds = std::atof(value);
    } else {
      return false;
    }
  }
  return argc % 2 == 1 && options.seconds > 0 && (options.hand == "right" || options.hand == "left");
}

}  // namespace

bool ParseArguments(int argc, char** argv, Options& options) {
  const std::string program = options.name;
  if (Parse(argc, argv, options)) return true;
  std::fprintf(stderr, "usage: %s [--hand right|left] [--seconds S] [--name NAME]\n", program.c_str());
  return false;
}

}  // namespace example
