// printf into a string, for lines of tables.
#pragma once

#include <cstdarg>
#include <cstdio>
#include <string>

namespace omni::tools {

// At most 255 characters; the rest is cut off.
[[gnu::format(printf, 1, 2)]] inline std::string Printed(const char* format, ...) {
  char text[256];
  std::va_list arguments;
  va_start(arguments, format);
  std::vsnprintf(text, sizeof(text), format, arguments);
  va_end(arguments);
  return text;
}

}  // namespace omni::tools
