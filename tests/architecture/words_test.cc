// Words that this project used in a sense of its own, or that other projects do not use: none in code, help and docs.
// The terms to use are those of docs/conventions.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <fstream>
#include <iterator>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/architecture/includes.h"

namespace omni::architecture {
namespace {

struct Retired {
  const char* hint;     // lower case; in every line that the pattern finds
  const char* pattern;  // ECMAScript; words without regard to case, names as they are written
  const char* instead;
  const char* example;
};
constexpr Retired kRetired[] = {
    {"told", R"((\b|_)told(\b|_))", "notified, reported, received, sent", "the client is told"},
    {"tells", R"(\btells\b)", "reports, shows, returns", "what it tells of the pen"},
    {"anew", R"(\banew\b)", "again, from scratch", "it is built anew"},
    {"in vain", R"(\bin vain\b)", "without success", "tried in vain"},
    {"farther", R"(\bfarther\b)", "further, beyond", "a pen that is farther away"},
    {"mend", R"(\bmend(s|ed|ing)?\b)", "fix", "mend the manifest"},
    {"nobody", R"(\bnobody (hears|listens)\b)", "without a listener", "nobody hears it"},
    {"as drawn", R"(\bas drawn\b)", "nominal", "a base as drawn"},
    {"hardly ever", R"(\bhardly ever\b)", "almost never", "which it hardly ever is"},
    {"whence", R"(\bwhence\b)", "from which", "whence it came"},
    {"thereof", R"(\bthereof\b)", "of it", "a part thereof"},
    {"of old", R"(\bof old\b)", "as before", "as of old"},
    {"tell", R"(\bTell(All|Force|Faults|Findings|Placements|Constraints)\b)", "Notify, Send, Report", "TellAll()"},
    {"ask", R"(\bAsk(For)?(Anew|Bodies|Fault|Hello|Loader|Placement|Record|Scene|Status|Textures)\b)", "Request, Query",
     "AskStatus()"},
    {"lookat", R"(\bLookAt\w*\()", "Check, Measure", "LookAtRoom()"},
    {"take", R"(\bTake(Answer|Fresh|News|Notices|Problem|Pulses|Result|Status|Written)\b)", "Pop, Handle",
     "TakeStatus()"},
    {"offer", R"(\bOffer(Of|State|edTo)?\b(?= [a-z]|\())", "StiffnessBound", "Offer given = input.offer"},
    {"touchables", R"(\bTouchables\b)", "ContactScene", "const Touchables& scene"},
    {"meet", R"(\bMeet(All|ing|ings)\b(?=[ (]))", "ContactGeometry, MeasureContacts", "Meeting met"},
    {"workshop", R"(\b(Add|Has)?Workshops?\b(?=[ (&*]))", "SculptSession", "class Workshop {"},
    {"story", R"(\b([A-Z]\w*)?Story\b)", "Scenario", "LoopStory"},
    {"quiet", R"(\bQuiet(Watch|Timing|Device)\b)", "IdleWatch, IdleTiming, SilentDevice", "QuietWatch watch"},
    {"feel", R"(\b(SculptFeel|HapticFeel|FeelRow|FeelOf)\b)", "parameters", "SculptFeel feel"},
    {"tamed", R"(\bTamed\b)", "Clamped", "Tamed(sample)"},
    {"hand_at_wall", R"(\bhand_at_wall\b)", "virtual_wall", "hand_at_wall.h"},
    {"command_life", R"(\bcommand_life\b)", "command_ttl", "command_life.h"},
};

std::regex PatternOf(const Retired& row) {
  const std::string pattern = row.pattern;
  const bool is_name = std::any_of(pattern.begin(), pattern.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
  return std::regex(pattern, is_name ? std::regex::ECMAScript : std::regex::ECMAScript | std::regex::icase);
}

// "WORD: use ..." of every retired word in the line.
std::vector<std::string> RetiredIn(const std::string& line) {
  std::string lower = line;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  std::vector<std::string> found;
  for (const Retired& row : kRetired) {
    std::smatch match;
    if (lower.find(row.hint) != std::string::npos && std::regex_search(line, match, PatternOf(row)))
      found.push_back("\"" + match.str() + "\": use " + row.instead);
  }
  return found;
}

// Names of faults and rules are frozen: in documents they are quoted or bold.
std::string WithoutNames(const std::string& line) {
  static const std::regex name(R"(`[^`]*`|\*\*[^*]*\*\*)");
  return std::regex_replace(line, name, "``");
}

// Rows of benchmarks keep their words, so that figures of before can be found.
bool IsFrozen(const std::string& line) { return line.find("xrLocateSpace tells its pose") != std::string::npos; }

void Check(const std::string& path, const std::string& text) {
  std::istringstream lines(text);
  int number = 0;
  for (std::string line; std::getline(lines, line);) {
    ++number;
    if (IsFrozen(line) || RetiredIn(line).empty()) continue;
    const bool is_page = path.size() > 3 && path.substr(path.size() - 3) == ".md";
    for (const std::string& found : RetiredIn(is_page ? WithoutNames(line) : line))
      ADD_FAILURE() << path << ":" << number << ": " << found;
  }
}

TEST(Words, RetiredOnesAreNotUsed) {
  SourceTree tree = ReadTree(OMNI_SOURCE_DIR, {"docs", "firmware", "layer", "manifests", "scenes", "service", "tests"},
                             {".c", ".cc", ".cmake", ".cpp", ".h", ".md", ".py", ".sh", ".toml", ".ts", ".txt"});
  tree.merge(ReadTree(OMNI_SOURCE_DIR, {"scripts"}, {"", ".cmake", ".py", ".sh"}));
  tree.erase("docs/benchmarks.md");
  tree.erase("tests/architecture/words_test.cc");
  EXPECT_GT(tree.size(), 1500U) << "the sources were found";
  for (const auto& [path, text] : tree) Check(path, text);
  for (const char* name : {"README.md", "SECURITY.md", "CMakeLists.txt"}) {
    std::ifstream file(std::string(OMNI_SOURCE_DIR) + "/" + name);
    Check(name, {std::istreambuf_iterator<char>(file), {}});
  }
}

TEST(Words, EachRetiredOneIsFound) {
  for (const Retired& row : kRetired) EXPECT_EQ(RetiredIn(row.example).size(), 1U) << row.example;
  EXPECT_TRUE(RetiredIn("the answer is sent again; tell them apart; further, fixed, nominal").empty());
  EXPECT_EQ(WithoutNames("| `append-starts-anew` | appended |"), "| `` | appended |");
}

}  // namespace
}  // namespace omni::architecture
