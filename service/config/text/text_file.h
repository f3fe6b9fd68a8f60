// Reads and writes settings files.
#pragma once

#include <cstddef>
#include <string>

#include "service/base/result.h"

namespace omni::config {

inline constexpr std::size_t kMaxSettingsBytes = 1 << 20;  // a longer file is refused

// A regular file of sane size; never blocks.
base::Result<std::string> ReadTextFile(const std::string& path);

// Replaces the old file as a whole or not at all; makes missing folders. The error names the path.
base::Status WriteTextFile(const std::string& path, const std::string& text);

}  // namespace omni::config
