// Text in fixed fields: written so that it is always terminated, read so that it is always printable UTF-8.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>

namespace omni::protocol {

// Copies `text` up to its first NUL into `field`, cut at a character's boundary; the rest of `field` is zeroed.
void SetField(char* field, std::size_t field_bytes, std::string_view text) noexcept;

template <std::size_t N>
void SetField(char (&field)[N], std::string_view text) noexcept {
  SetField(field, N, text);
}

bool IsTerminated(const char* field, std::size_t field_bytes) noexcept;

template <std::size_t N>
bool IsTerminated(const char (&field)[N]) noexcept {
  return IsTerminated(field, N);
}

// The text with every control character and every byte that is not valid UTF-8 replaced by '?': texts of clients end up
// in logs, terminals and JSON.
std::string Printable(std::string_view text);

}  // namespace omni::protocol
