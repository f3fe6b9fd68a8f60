// Equations of docs/theory: their numbers ascend, and what cites one cites one that exists.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <regex>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "tests/architecture/comments.h"
#include "tests/architecture/includes.h"

namespace omni::architecture {
namespace {

const std::string kTheory = "docs/theory/";

// The equations of a document in its order: "section.number" where sections are numbered, else "number". An equation's
// number ends its line, or where no line ends so, it begins a paragraph.
struct Equations {
  std::vector<std::string> numbers;
  std::string problem;  // the first that is out of order
};

Equations EquationsOf(const std::string& document) {
  static const std::regex section(R"(## (\d+)\. .*)");
  static const std::regex at_end(R"((?:.*  )?\s*\((\d+(?:\.\d+)?)\)(?:  .*)?)"), at_start(R"(\((\d+\.\d+)\) .*)");
  const auto read = [&](const std::regex& label) {
    Equations found;
    std::istringstream lines(document);
    std::string heading, before;
    int count = 0;
    for (std::string line; std::getline(lines, line); before = line) {
      std::smatch match;
      if (std::regex_match(line, match, section)) {
        heading = match[1].str() + ".";
        count = 0;
      }
      if (&label == &at_start && !before.empty()) continue;
      if (!std::regex_match(line, match, label)) continue;
      found.numbers.push_back(match[1]);
      const std::string expected = heading + std::to_string(++count);
      if (found.problem.empty() && match[1] != expected)
        found.problem = "(" + match[1].str() + ") instead of (" + expected + ")";
    }
    return found;
  };
  const Equations ends = read(at_end);
  return ends.numbers.empty() ? read(at_start) : ends;
}

// Name of a document, as in "tracking.md" -> its equations.
using Theory = std::map<std::string, std::set<std::string>>;

// "NAME.md (n)" of what is not in `theory`, in one text. Numbers after a document's name are its own; those with a dot
// elsewhere are `home`'s, else those of the document that was named last.
std::vector<std::string> WrongCitations(const std::string& text, const Theory& theory, const std::string& home = {}) {
  static const std::regex cited(R"([a-z-]+\.md|\([1-9]\d*(?:\.[1-9]\d*)?\))");
  static const std::regex between(R"([\])]*,?[\s/]*(?:(?:and|to|-)[\s/]*)?)");
  std::vector<std::string> wrong;
  std::string named = home;
  std::size_t end = std::string::npos;  // of the name or number before
  for (std::sregex_iterator at(text.begin(), text.end(), cited); at != std::sregex_iterator(); ++at) {
    const std::string found = at->str();
    const auto begin = static_cast<std::size_t>(at->position());
    if (found[0] != '(') {
      const bool is_known = theory.count(found) != 0;
      if (is_known) named = found;
      end = is_known ? begin + found.size() : std::string::npos;
      continue;
    }
    const bool follows = end != std::string::npos && std::regex_match(text.substr(end, begin - end), between);
    const bool is_argument = begin > 0 && std::isspace(static_cast<unsigned char>(text[begin - 1])) == 0;
    end = follows ? begin + found.size() : std::string::npos;
    if (!follows && !home.empty()) named = home;
    if (named.empty() || (!follows && (is_argument || found.find('.') == std::string::npos))) continue;
    if (theory.at(named).count(found.substr(1, found.size() - 2)) == 0) wrong.push_back(named + " " + found);
  }
  return wrong;
}

// Where numbers without a document's name are those of one document; the first that fits.
struct Home {
  const char* folder;
  const char* document;
};
constexpr Home kHomes[] = {
    {"service/haptics/deformable/", "deformable.md"},
    {"service/haptics/sculpt/", "sculpting.md"},
    {"service/haptics/", "haptics.md"},
    {"service/loop/", "haptics.md"},
    {"service/tracker/", "tracking.md"},
    {"service/calibration/", "calibration.md"},
    {"service/actuation/", "actuation.md"},
    {"firmware/core/", "firmware.md"},
};
std::string HomeOf(const std::string& path) {
  for (const Home& home : kHomes) {
    if (path.rfind(home.folder, 0) == 0) return home.document;
  }
  return {};
}

const SourceTree& Documents() {
  static const SourceTree kTree = ReadTree(OMNI_SOURCE_DIR, {"docs"}, {".md"});
  return kTree;
}

Theory ReadTheory() {
  Theory theory;
  for (const auto& [path, text] : Documents()) {
    if (path.compare(0, kTheory.size(), kTheory) != 0) continue;
    const Equations equations = EquationsOf(text);
    EXPECT_EQ(equations.problem, "") << path;
    theory[path.substr(kTheory.size())] = {equations.numbers.begin(), equations.numbers.end()};
  }
  return theory;
}

TEST(Equations, NumbersAscendAndCitedOnesExist) {
  const Theory theory = ReadTheory();
  ASSERT_GT(theory.size(), 10U);
  EXPECT_GT(theory.at("tracking.md").size(), 30U);
  for (const auto& [path, text] : Documents()) {
    const std::string name = path.substr(path.rfind('/') + 1);
    for (const std::string& wrong : WrongCitations(text, theory, theory.count(name) != 0 ? name : ""))
      ADD_FAILURE() << path << ": " << wrong << " does not exist";
  }
  for (const auto& [path, text] :
       ReadTree(OMNI_SOURCE_DIR, {"layer", "service", "firmware", "scenes", "tests"}, {".c", ".cc", ".h", ".ts"})) {
    std::string comments;
    for (const Comment& comment : ReadSource(text).comments) comments += comment.text + "\n\n";
    for (const std::string& wrong : WrongCitations(comments, theory, HomeOf(path)))
      ADD_FAILURE() << path << ": " << wrong << " does not exist";
  }
}

TEST(Equations, OrderIsJudged) {
  EXPECT_EQ(EquationsOf("    a = b    (1)\nso (2) and\n    c  (2)  far away\n").problem, "");
  EXPECT_EQ(EquationsOf("    a = b    (1)\n    c = d    (3)\n").problem, "(3) instead of (2)");
  EXPECT_EQ(EquationsOf("    a = b    (1)\n    c = d    (1)\n").problem, "(1) instead of (2)");
  EXPECT_EQ(EquationsOf("## 1. One\n    a  (1.1)\n## 2. Two\n    b  (2.1)\n    c  (2.2)\n").problem, "");
  EXPECT_EQ(EquationsOf("## 1. One\n    a  (1.1)\n## 2. Two\n    b  (1.2)\n").problem, "(1.2) instead of (2.1)");
  EXPECT_EQ(EquationsOf("## 1. One\n\n(1.1) a, as in\n(1.1) too\n\n(1.2) b\n").problem, "");
  EXPECT_EQ(EquationsOf("## 1. One\n\n(1.2) b\n\n(1.1) a\n").problem, "(1.2) instead of (1.1)");
}

TEST(Equations, CitationsAreJudged) {
  const Theory theory{{"pen.md", {"1.1", "1.2"}}, {"coil.md", {"1", "2"}}};
  EXPECT_TRUE(
      WrongCitations("docs/theory/coil.md (1), (2), pen.md (1.1) -\n (1.2); (1.1), a stiffness (3)", theory).empty());
  EXPECT_EQ(WrongCitations("docs/theory/coil.md (1) to\n// (3)", theory), std::vector<std::string>{"coil.md (3)"});
  EXPECT_EQ(WrongCitations("[pen](pen.md) (1.3)", theory), std::vector<std::string>{"pen.md (1.3)"});
  EXPECT_EQ(WrongCitations("see pen.md. Softly   (2.1)", theory), std::vector<std::string>{"pen.md (2.1)"});
  EXPECT_EQ(WrongCitations("as (1.7)", theory, "pen.md"), std::vector<std::string>{"pen.md (1.7)"});
}

}  // namespace
}  // namespace omni::architecture
