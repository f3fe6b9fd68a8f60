// The command line of programs that `omni-bench` runs: flags, and options with a value.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <initializer_list>
#include <optional>
#include <string>

namespace omni::bench {

// `flag` or `value` is set.
struct Argument {
  const char* name;
  bool* flag = nullptr;
  std::string* value = nullptr;
};

// Empty: continue. Else the exit status: 0 after --help, 2 for an unknown argument.
inline std::optional<int> ParseArguments(int argc, char** argv, const std::string& program,
                                         std::initializer_list<Argument> arguments) {
  std::string usage = "usage: " + program;
  for (const Argument& a : arguments) usage += " [" + std::string(a.name) + (a.flag != nullptr ? "]" : " VALUE]");
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    if (word == "--help") {
      std::printf("%s\n", usage.c_str());
      return 0;
    }
    bool taken = false;
    for (const Argument& a : arguments) {
      if (word != a.name || (a.flag == nullptr && i + 1 == argc)) continue;
      taken = true;
      if (a.flag != nullptr) {
        *a.flag = true;
      } else {
        *a.value = argv[++i];
      }
      break;
    }
    if (taken) continue;
    std::fprintf(stderr, "%s: '%s' is not an argument, or its value is missing\n%s\n", program.c_str(), word.c_str(),
                 usage.c_str());
    return 2;
  }
  return std::nullopt;
}

// A number that strtoull reads; 0 for anything else.
inline unsigned long long Number(const std::string& text) { return std::strtoull(text.c_str(), nullptr, 10); }

}  // namespace omni::bench
