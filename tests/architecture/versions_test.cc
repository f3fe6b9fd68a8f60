// docs/protocol/versions.md names the constants of the sources; the changelog has the version of the build.
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

TEST(Versions, TableNamesTheConstantsOfTheSources) {
  const std::regex row(R"(^\| [^|]+ \| `(\w+)` \| ([^ |]+) \|$)");
  std::istringstream page(TextOf("docs/protocol/versions.md"));
  int rows = 0;
  for (std::string line; std::getline(page, line);) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    ++rows;
    EXPECT_NE(NumberOf(match[1], TextOf(match[2])), "") << match[1] << " of " << match[2];
  }
  EXPECT_EQ(rows, 12);
}

TEST(Versions, PageAndItsServerSpeakTheSame) {
  EXPECT_EQ(NumberOf("kProtocol", TextOf("service/page/src/types.ts")),
            NumberOf("kPageVersion", TextOf("service/monitor/page/page_messages.h")));
}

TEST(Versions, ChangelogHasTheVersionOfTheBuild) {
  std::smatch match;
  const std::string cmake = TextOf("CMakeLists.txt"), changelog = TextOf("CHANGELOG.md");
  ASSERT_TRUE(std::regex_search(cmake, match, std::regex(R"(project\(omni VERSION (\d+\.\d+\.\d+))")));
  EXPECT_TRUE(std::regex_search(changelog, std::regex("\n## " + match[1].str() + " - \\d{4}-\\d{2}-\\d{2}\n")));
}

}  // namespace
}  // namespace omni::architecture
