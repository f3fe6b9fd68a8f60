// docs/protocol/versions.md has the numbers that the sources have.
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>

namespace omni::architecture {
namespace {

std::string TextOf(const std::string& path) {
  std::ifstream file(std::string(OMNI_SOURCE_DIR) + "/" + path);
  return {std::istreambuf_iterator<char>(file), {}};
}

// The number that `constant` has in the text; empty: it is not there.
std::string NumberOf(const std::string& constant, const std::string& text) {
  std::smatch match;
  const std::regex pattern("\\b" + constant + " = (\\d+);");
  return std::regex_search(text, match, pattern) ? match[1].str() : std::string();
}

TEST(Versions, TableHasTheNumbersOfTheSources) {
  const std::regex row(R"(^\| [^|]+ \| (\d+) \| `(\w+)` \| ([^ |]+) \|$)");
  std::istringstream page(TextOf("docs/protocol/versions.md"));
  int rows = 0;
  for (std::string line; std::getline(page, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    ++rows;
    EXPECT_EQ(NumberOf(match[2], TextOf(match[3])), match[1].str()) << match[2] << " of " << match[3];
  }
  EXPECT_EQ(rows, 9);
}

TEST(Versions, ChangelogHasTheVersionOfTheBuild) {
  std::smatch match;
  const std::string cmake = TextOf("CMakeLists.txt"), changelog = TextOf("CHANGELOG.md");
  ASSERT_TRUE(std::regex_search(cmake, match, std::regex(R"(project\(omni VERSION (\d+\.\d+\.\d+))")));
  EXPECT_TRUE(std::regex_search(changelog, std::regex("\n## " + match[1].str() + " - \\d{4}-\\d{2}-\\d{2}\n")));
}

}  // namespace
}  // namespace omni::architecture
