// Reads and writes settings files, and checks the text of TOML.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

#include "service/base/result.h"

namespace omni::config {

inline constexpr std::size_t kMaxSettingsBytes = 1 << 20;  // a longer file is refused

// A regular file of sane size; never blocks.
base::Result<std::string> ReadTextFile(const std::string& path);

// Replaces the old file as a whole or not at all; makes missing folders. The error names the path.
base::Status WriteTextFile(const std::string& path, const std::string& text);

// toml++ recurses as deep as a file nests its keys, and a file of 80 kB can nest them deeper than the stack allows. So
// the text is scanned first: one pass without recursion, memory or toml++.
struct TomlLimits {
  std::size_t bytes = kMaxSettingsBytes;
  std::size_t values = 50'000;  // keys, tables and elements of arrays
  std::size_t parts = 16;       // of a key or a table's name: a.b.c has three
  std::size_t depth = 16;       // arrays and inline tables in each other
  std::size_t word = 256;       // bytes of a number or of a key without quotes
};

// The error names the file, the line and the limit.
base::Status CheckToml(std::string_view text, const std::string& file, const TomlLimits& limits = {});

}  // namespace omni::config
