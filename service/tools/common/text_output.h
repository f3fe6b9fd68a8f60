// Text of subcommands, for people.
#pragma once

#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <string>

namespace omni::tools {

// To stdout, as wide as the terminal. Not for JSON and tables.
void Print(const std::string& text);

// printf into a string, for lines of tables. At most 255 characters; the rest is cut off.
[[gnu::format(printf, 1, 2)]] inline std::string Printed(const char* format, ...) {
  char text[256];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

// "1 triangle", "12 triangles"; `what`: the noun in the singular, to which an s is added.
inline std::string Plural(std::size_t count, const std::string& what) {
  return std::to_string(count) + " " + what + (count == 1 ? "" : "s");
}

}  // namespace omni::tools
