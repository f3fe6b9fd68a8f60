// Files that a subcommand leaves behind.
#pragma once

#include <string>

namespace omni::tools {

// Empty: written. Else "PATH: cannot be written (REASON); check the folder".
std::string WriteText(const std::string& path, const std::string& text);

}  // namespace omni::tools
