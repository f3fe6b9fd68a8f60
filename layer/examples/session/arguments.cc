#include "session/arguments.h"

#include <cstdio>
#include <cstdlib>

namespace example {
namespace {

constexpr const char* kUsage = "usage: %s [--hand right|left] [--seconds S] [--name NAME]%s\n";

// Empty: accepted.
std::string Take(const std::string& key, const char* value, Options& options) {
  if (key != "--hand" && key != "--name" && key != "--seconds") return "there is no option '" + key + "'";
  if (value == nullptr) return key + ": its value is missing";
  if (key == "--name") {
    options.name = value;
  } else if (key == "--hand") {
    options.hand = value;
    if (options.hand != "right" && options.hand != "left")
      return "--hand: '" + options.hand + "' must be right or left";
  } else {
    char* end = nullptr;
    options.seconds = std::strtod(value, &end);
    if (end == value || *end != '\0' || !(options.seconds > 0))
      return "--seconds: '" + std::string(value) + "' must be a number of seconds above 0";
  }
  return {};
}

}  // namespace

std::optional<int> ParseArguments(int argc, char** argv, Options& options) {
  const std::string program = options.name;
  for (int i = 1; i < argc; i += 2) {
    const std::string key = argv[i];
    if (key == "--help" || key == "-h") {
      std::printf(kUsage, program.c_str(), "");
      return 0;
    }
    const std::string problem = Take(key, i + 1 < argc ? argv[i + 1] : nullptr, options);
    if (problem.empty()) continue;
    std::fprintf(stderr, kUsage, program.c_str(), ("; " + problem).c_str());
    return 2;
  }
  return std::nullopt;
}

}  // namespace example
