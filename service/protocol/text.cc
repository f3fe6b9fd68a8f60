#include "service/protocol/text.h"

#include <algorithm>
#include <cstring>

namespace omni::protocol {
namespace {

unsigned char Byte(std::string_view text, std::size_t i) noexcept { return static_cast<unsigned char>(text[i]); }

bool IsContinuation(std::string_view text, std::size_t i) noexcept { return (Byte(text, i) & 0xC0) == 0x80; }

// Bytes of the printable character at the start of `text`, 0 if there is none.
// Well-formed UTF-8: The Unicode Standard, table 3-7 (no overlong forms, no surrogates, up to U+10FFFF).
std::size_t PrintableLength(std::string_view text) noexcept {
  const unsigned char lead = Byte(text, 0);
  if (lead < 0x80) return lead >= 0x20 && lead != 0x7F ? 1 : 0;
  const std::size_t length = lead >= 0xC2 && lead <= 0xDF   ? 2
                             : (lead & 0xF0) == 0xE0        ? 3
                             : lead >= 0xF0 && lead <= 0xF4 ? 4
                                                            : 0;
  if (length == 0 || text.size() < length) return 0;
  for (std::size_t i = 1; i < length; ++i) {
    if (!IsContinuation(text, i)) return 0;
  }
  const unsigned char second = Byte(text, 1);
  if (lead == 0xC2 && second < 0xA0) return 0;  // C1 control characters: terminals obey them
  if ((lead == 0xE0 && second < 0xA0) || (lead == 0xED && second > 0x9F)) return 0;
  if ((lead == 0xF0 && second < 0x90) || (lead == 0xF4 && second > 0x8F)) return 0;
  return length;
}

}  // namespace

void SetField(char* field, std::size_t field_bytes, std::string_view text) noexcept {
  text = text.substr(0, text.find('\0'));
  std::size_t length = std::min(text.size(), field_bytes - 1);
  if (length < text.size()) {
    while (length > 0 && IsContinuation(text, length)) --length;
  }
  std::memset(field, 0, field_bytes);
  if (length > 0) std::memcpy(field, text.data(), length);
}

bool IsTerminated(const char* field, std::size_t field_bytes) noexcept {
  return std::memchr(field, 0, field_bytes) != nullptr;
}

std::string Printable(std::string_view text) {
  std::string clean;
  clean.reserve(text.size());
  while (!text.empty()) {
    const std::size_t length = PrintableLength(text);
    if (length == 0) {
      clean += '?';
    } else {
      clean += text.substr(0, length);
    }
    text.remove_prefix(std::max<std::size_t>(length, 1));
  }
  return clean;
}

}  // namespace omni::protocol
