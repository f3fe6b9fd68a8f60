// What subcommands print, for people and as JSON.
#pragma once

#include <cstdarg>
#include <cstddef>
#include <cstdio>
#include <iosfwd>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/base/files/json_document.h"

namespace omni::tools {

// Text of subcommands, for people.

// To stdout, as wide as the terminal. Not for JSON and tables.
void Print(const std::string& text);

// printf into a string, for lines of tables. At most 255 characters; the rest is cut off.
[[gnu::format(printf, 1, 2)]] inline std::string Format(const char* format, ...) {
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

// JSON as text for people, in which missing values and other types become "-", and JSON as output. Values themselves:
// base/files/json_document.h.

using base::ArrayAt;
using base::NumberAt;
using base::ParseJsonOrNull;
using base::TrueAt;

// The value at a JSON pointer ("/tick/count") as text for people; numbers with `digits` after the point.
std::string TextAt(const nlohmann::json& document, const char* pointer, int digits = 0);

// Indented. Names come from other programs: invalid UTF-8 is replaced.
void WriteJson(std::ostream& out, const nlohmann::ordered_json& document);

// The same to stdout.
void PrintJson(const nlohmann::json& document);
void PrintJson(const nlohmann::ordered_json& document);

// Fail, or for kExitNoService the same with that status. `as_json`: stdout gets {"error": text}, so that a script
// always reads JSON.
int FailWith(bool as_json, const std::string& command, const std::string& error, int status = 1);

// The first line of output while omnid runs a simulation, with newline; otherwise empty.
std::string SimulationLine(const nlohmann::json& status);

// "name", or "name (a simulation)" if the device is one and its name does not say so; "-" if there is none.
std::string DeviceName(const nlohmann::json& status);

}  // namespace omni::tools
