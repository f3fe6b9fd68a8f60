// Exported functions of one word: one_word_names.txt has each, with why that is enough.
#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <set>
#include <sstream>
#include <string>

#include "tests/architecture/includes.h"

namespace omni::architecture {
namespace {

// Names of the functions of one word that a header declares.
std::set<std::string> OneWordFunctions(const std::string& header) {
  static const std::regex word(R"([\s&*]([A-Z][a-z0-9]+)\()");
  static const std::regex declaration(R"((template\s*<[^()]*>\s*)?(\[\[[\w:]+\]\]\s*)?)"
                                      R"((?!return\b|else\b|case\b|new\b|delete\b|throw\b|using\b|#|friend class))"
                                      R"([\w:<>,&*\s]*[\w>&*]\s*)");
  std::set<std::string> names;
  std::istringstream lines(header);
  for (std::string line; std::getline(lines, line);) {
    line.resize(std::min(line.find("//"), line.size()));
    line.erase(0, line.find_first_not_of(' '));
    std::smatch found;
    if (!std::regex_search(line, found, word)) continue;
    if (std::regex_match(line.substr(0, static_cast<std::size_t>(found.position())), declaration))
      names.insert(found[1]);
  }
  return names;
}

TEST(OneWordNames, EachIsListedWithItsReason) {
  std::set<std::string> listed, found;
  std::ifstream list(std::string(OMNI_SOURCE_DIR) + "/tests/architecture/one_word_names.txt");
  std::string last;
  for (std::string line; std::getline(list, line);) {
    if (line.empty() || line[0] == '#') continue;
    const std::size_t colon = line.find(": ");
    ASSERT_TRUE(colon != std::string::npos && line.size() > colon + 2) << line << ": no reason";
    const std::string name = line.substr(0, colon);
    EXPECT_LT(last, name) << "the list is sorted";
    listed.insert(last = name);
  }
  for (const auto& [path, text] : ReadTree(OMNI_SOURCE_DIR, {"firmware", "layer/src", "service"}, {".h"})) {
    for (const std::string& name : OneWordFunctions(text)) {
      found.insert(name);
      EXPECT_EQ(listed.count(name), 1U) << path << ": " << name
                                        << "(): a name that says what is done to what, or a row of the list";
    }
  }
  ASSERT_GT(found.size(), 200U) << "the headers were found";
  for (const std::string& name : listed) EXPECT_EQ(found.count(name), 1U) << name << " is listed, and no header has it";
}

TEST(OneWordNames, DeclarationsAreFound) {
  const std::set<std::string> two{"Fall", "Where"};
  EXPECT_EQ(OneWordFunctions("double Fall(double t_s);\n  [[nodiscard]] Vec3& Where() const;\n"), two);
  EXPECT_TRUE(
      OneWordFunctions("  return Fall(1);\n  x = Where();\n  f.Fall(2);  // int Doom()\nint FallTime();\n").empty());
}

}  // namespace
}  // namespace omni::architecture
