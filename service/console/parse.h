// A program's command line: help as wide as the terminal, wrong words named with the nearest right one, and the exit
// statuses of exit_status.h.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "service/console/exit_status.h"

namespace CLI {
class App;
class Validator;
}  // namespace CLI

namespace omni::console {

// `--version`: "PROGRAM VERSION".
void AddVersion(CLI::App& app, const std::string& version);

// Nothing: go on. Else the program's exit status: help or version was printed (0), a callback ended with
// CLI::RuntimeError(status), or the words are wrong (2, with one line on stderr). `app` has its program's name.
std::optional<int> Parse(CLI::App& app, int argc, const char* const* argv);
// The same; `words` follow the program's name.
std::optional<int> Parse(CLI::App& app, std::vector<std::string> words);

// Checks of values, for CLI::Option::check.
CLI::Validator OneOf(std::vector<std::string> words);
// A file to write, which can only be what its name has to say: extension ".glb", kind "binary glTF".
CLI::Validator WritesOnly(const std::string& extension, const std::string& kind);

// Writes "COMMAND: MESSAGE" to stderr; kExitFailed. command: "omni calibrate".
int Fail(const std::string& command, const std::string& message);

}  // namespace omni::console
