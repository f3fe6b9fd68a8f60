// Bytes as hexadecimal text, for comparison.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace omni::support {

inline std::string Hex(const std::vector<std::uint8_t>& bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    constexpr char kDigits[] = "0123456789abcdef";
    text += kDigits[byte >> 4];
    text += kDigits[byte & 15];
  }
  return text;
}

}  // namespace omni::support
