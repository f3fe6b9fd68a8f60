// Builds a line or a small report without a library. Text that does not fit is cut off.
#pragma once

#include <cstddef>
#include <cstdint>

namespace omni::firmware::board {

class Text {
 public:
  Text& Add(const char* text) noexcept {
    while (*text != '\0') Put(*text++);
    return *this;
  }
  Text& Add(std::uint32_t number) noexcept {
    char digits[10];
    int count = 0;
    do {
      digits[count++] = static_cast<char>('0' + number % 10);
      number /= 10;
    } while (number > 0);
    while (count > 0) Put(digits[--count]);
    return *this;
  }
  // Eight digits.
  Text& AddHex(std::uint32_t number) noexcept {
    for (int shift = 28; shift >= 0; shift -= 4) Put("0123456789abcdef"[(number >> shift) & 15U]);
    return *this;
  }

  const char* c_str() const noexcept { return text_; }
  std::size_t size() const noexcept { return size_; }

 private:
  void Put(char c) noexcept {
    if (size_ + 1 < sizeof text_) text_[size_++] = c;
  }

  char text_[2048] = {};
  std::size_t size_ = 0;
};

// The decimal number at the start of `text`; false: there is none, or it is followed by anything but the end or a
// space.
inline bool ParseNumber(const char* text, std::uint32_t& number) noexcept {
  std::uint64_t value = 0;
  const char* at = text;
  for (; *at >= '0' && *at <= '9'; ++at) {
    value = 10 * value + static_cast<std::uint64_t>(*at - '0');
    if (value > 0xFFFFFFFFU) return false;
  }
  if (at == text || (*at != '\0' && *at != ' ')) return false;
  number = static_cast<std::uint32_t>(value);
  return true;
}

}  // namespace omni::firmware::board
