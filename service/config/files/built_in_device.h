// The texts of manifests/device/omni.toml, twin.toml, room.toml and marks.toml, put into the binary by CMake.
#pragma once

#include <cstdio>
#include <cstdlib>
#include <string>
#include <utility>

#include "service/base/result.h"

namespace omni::config {

extern const char* const kBuiltInDeviceText;
extern const char* const kBuiltInTwinText;
extern const char* const kBuiltInRoomText;
extern const char* const kBuiltInMarksText;

// Parses one of them. An error aborts the program: the tests of such a build fail.
template <class T>
T ParsedBuiltIn(base::Result<T> (*parse)(const std::string& text, const std::string& name), const char* text,
                const char* file) {
  base::Result<T> parsed = parse(text, std::string("built-in ") + file);
  if (!parsed.ok()) {
    std::fprintf(stderr, "%s\n", parsed.error().c_str());
    std::abort();
  }
  return std::move(*parsed);
}

}  // namespace omni::config
