// Text output and files of subcommands.
#pragma once

#include <string>

namespace omni::tools {

// To stdout, as wide as the terminal. Not for JSON and tables.
void Print(const std::string& text);

// Empty: written. Else "PATH: cannot be written (REASON); check the folder".
std::string WriteText(const std::string& path, const std::string& text);

}  // namespace omni::tools
