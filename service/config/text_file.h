// Reads a settings file: regular, of sane size, never blocking.
#pragma once

#include <cstddef>
#include <string>

#include "service/base/result.h"

namespace omni::config {

inline constexpr std::size_t kMaxSettingsBytes = 1 << 20;  // a longer file is refused

base::Result<std::string> ReadTextFile(const std::string& path);

}  // namespace omni::config
