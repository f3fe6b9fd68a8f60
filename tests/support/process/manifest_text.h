// The text of a shipped manifest, and the same with one mistake in it.
#pragma once

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>

namespace omni::test {

// `below`: path below manifests/.
inline std::string ManifestText(const std::string& below) {
  std::ifstream file(std::string(OMNI_SOURCE_DIR "/manifests/") + below);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

// `text` with the first occurrence of `from` replaced; it must be there.
inline std::string Replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

}  // namespace omni::test
