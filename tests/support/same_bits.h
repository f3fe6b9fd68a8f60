// Bitwise equality: -0 differs from 0, and a NaN equals itself. Padding does not count.
#pragma once

#include <array>
#include <bit>
#include <cstddef>

namespace omni::support {

template <class T>
std::array<std::byte, sizeof(T)> BitsOf(T value) {
#if __has_builtin(__builtin_clear_padding)
  __builtin_clear_padding(&value);
#endif
  return std::bit_cast<std::array<std::byte, sizeof(T)>>(value);
}

template <class T>
bool SameBits(const T& a, const T& b) {
  return BitsOf(a) == BitsOf(b);
}

}  // namespace omni::support
