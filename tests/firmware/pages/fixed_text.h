// Numbers of generated pages, rounded the same way everywhere.
#pragma once

#include <cmath>
#include <string>

namespace omni::firmware {

inline std::string Fixed(double value, int digits) {
  const long long scaled = std::llround(value * std::pow(10.0, digits));
  std::string text = std::to_string(scaled < 0 ? -scaled : scaled);
  if (digits > 0) {
    while (static_cast<int>(text.size()) <= digits) text.insert(0, "0");
    text.insert(text.size() - static_cast<std::size_t>(digits), ".");
  }
  return scaled < 0 ? "-" + text : text;
}

}  // namespace omni::firmware
