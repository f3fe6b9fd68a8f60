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
  const char* hint;  // lower case; in every line that the pattern finds
  const char*
      pattern;  // ECMAScript, of a line as Parts gives it: without regard to case, unless it has capitals itself
  const char* instead;
  std::vector<const char*> examples;
};
const Retired kRetired[] = {
    {"told", R"(\btold\b)", "notified, reported, received, sent", {"the client is told", "IsTold()", "told_at_ns"}},
    {"tell",
     R"(\btell(s|ing|ers?)?\b)",
     "notify, send, report, show, distinguish",
     {"what it tells of the pen", "telling it", "TellAll()", "void TellSomething(", "kTellAgain_ns", "stop_and_tell"}},
    {"anew", R"(\banew\b)", "again, from scratch", {"it is built anew", "AskAnew()"}},
    {"in vain", R"(\bin vain\b)", "without success", {"tried in vain"}},
    {"farther", R"(\bfarther\b)", "further, beyond", {"a pen that is farther away"}},
    {"mend", R"(\bmend(s|ed|ing)?\b)", "fix", {"mend the manifest", "MendedMesh"}},
    {"nobody", R"(\bnobody (hears|listens)\b)", "without a listener", {"nobody hears it"}},
    {"as drawn", R"(\bas drawn\b)", "nominal", {"a base as drawn"}},
    {"hardly ever", R"(\bhardly ever\b)", "almost never", {"which it hardly ever is"}},
    {"whence", R"((^|[^~])\bwhence\b)", "from which", {"whence it came"}},
    {"thereof", R"(\bthereof\b)", "of it", {"a part thereof"}},
    {"of old", R"(\bof old\b)", "as before", {"as of old"}},
    {"ask",
     R"(\bask(s|ed|ing)?~(for~)?(bodies|fault|hello|loader|placement|record|scene|status|texture)s?\b)",
     "Request, Query",
     {"AskStatus()", "AskedForScenes", "ask_loader"}},
    {"lookat", R"(\bLook~At(~\w+)*\()", "Check, Measure", {"LookAtRoom()"}},
    {"take",
     R"(\bTake~(Answer|Fresh|News|Notice|Problem|Pulse|Result|Status|Written)(s|es)?\b)",
     "Pop, Handle",
     {"TakeStatus()", "TakeResultAgain()"}},
    {"offer", R"(\bOffer(~(Of|State)|ed~To)?\b(?= [a-z]|\())", "StiffnessBound", {"Offer given = input.offer"}},
    {"touchables", R"(\btouchables\b)", "ContactScene", {"const Touchables& scene", "the touchables of a tick"}},
    {"meet", R"(\bMeet(ings?|~All)\b(?=[ (~]))", "ContactGeometry, MeasureContacts", {"Meeting met", "MeetAll(scene)"}},
    {"workshop",
     R"(\bworkshops?\b)",
     "SculptSession; of tools: machine shop",
     {"class Workshop {", "AddWorkshopFor(", "all workshops"}},
    {"stor", R"(\bstor(y|ies)\b)", "Scenario", {"LoopStory", "two stories", "story_of_a_pen"}},
    {"quiet",
     R"(\bquiet~(watch|timing|device)(s|es)?\b)",
     "IdleWatch, IdleTiming, SilentDevice",
     {"QuietWatch watch", "quiet_devices"}},
    {"feel", R"(\b((sculpt|haptic)~feel|feel~(rows?|of))\b)", "parameters", {"SculptFeel feel", "haptic_feel"}},
    {"tam", R"(\btam(e|es|ed|ing)\b)", "clamp", {"Tamed(sample)", "TameAll(", "taming it"}},
    {"hand_at_wall", R"(\bhand~at~wall\b)", "virtual_wall", {"hand_at_wall.h"}},
    {"command_life", R"(\bcommand~life\b)", "command_ttl", {"command_life.h"}},
};

std::regex PatternOf(const Retired& row) {
  const std::string pattern = row.pattern;
  const bool is_name = std::any_of(pattern.begin(), pattern.end(), [](char c) { return c >= 'A' && c <= 'Z'; });
  return std::regex(pattern, is_name ? std::regex::ECMAScript : std::regex::ECMAScript | std::regex::icase);
}

// The words of names apart: "kTellAll_ns" -> "k~Tell~All~ns".
std::string Parts(const std::string& line) {
  std::string parts;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const auto is = [&line](std::size_t at, int (*kind)(int)) {
      return at < line.size() && kind(static_cast<unsigned char>(line[at])) != 0;
    };
    const bool ends = is(i - 1, std::islower) || (is(i - 1, std::isupper) && is(i + 1, std::islower));
    if (is(i, std::isupper) && ends) parts += '~';
    parts += line[i] == '_' ? '~' : line[i];
  }
  return parts;
}

// "WORD: use ..." of every retired word in the line.
std::vector<std::string> RetiredIn(const std::string& line) {
  static const std::vector<std::regex> patterns = [] {
    std::vector<std::regex> all;
    for (const Retired& row : kRetired) all.push_back(PatternOf(row));
    return all;
  }();
  std::string lower = line;
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  std::vector<std::string> found;
  for (std::size_t i = 0; i < patterns.size(); ++i) {
    if (lower.find(kRetired[i].hint) == std::string::npos) continue;
    const std::string parts = Parts(line);
    std::smatch match;
    if (std::regex_search(parts, match, patterns[i]))
      found.push_back("\"" + match.str() + "\": use " + kRetired[i].instead);
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
  for (const Retired& row : kRetired) {
    for (const char* example : row.examples) EXPECT_EQ(RetiredIn(example).size(), 1U) << example;
  }
  for (const char* fine : {"the answer is sent again; distinguish them; further, fixed, nominal", "intelligent, stored",
                           "recommendedImageRectWidth", "ThrowsANewError", "constellation, satellite, stamina"})
    EXPECT_TRUE(RetiredIn(fine).empty()) << fine;
  EXPECT_EQ(WithoutNames("| `append-starts-anew` | appended |"), "| `` | appended |");
}

}  // namespace
}  // namespace omni::architecture
