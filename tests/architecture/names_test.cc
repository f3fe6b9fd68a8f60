// Comments and documents name files and identifiers that exist. Checked are paths of this repository, names of headers
// and sources, kConstants, Qualified::names, Functions(), in comments any other CamelCase, in documents that in `code`.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <functional>
#include <set>
#include <sstream>
#include <string>
#include <unordered_set>
#include <vector>

#include "tests/architecture/comments.h"
#include "tests/architecture/includes.h"

namespace omni::architecture {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kTops = {"docs",   "firmware", "layer",   "manifests",
                                        "scenes", "scripts",  "service", "tests"};
// Names of others, and what a reader replaces.
const std::unordered_set<std::string> kNotOurs = {"AddName",
                                                  "BenchName",
                                                  "ChipIdea",
                                                  "JsonCpp",
                                                  "MurmurHash3",
                                                  "RealtimeKit1",
                                                  "SysTick",
                                                  "ThreadSanitizer",
                                                  "libusb_interrupt_event_handler",
                                                  "openxr_loader_negotiation.h"};
const std::set<std::string> kInstalled = {"build", "etc", "include", "share", "usr"};
const std::string kOtherSources = "docs/howto/engines.md";  // it cites files of engines

bool Is(int (*kind)(int), char c) { return kind(static_cast<unsigned char>(c)) != 0; }
bool IsWord(char c) { return Is(std::isalnum, c) || c == '_'; }
bool Ends(const std::string& text, const std::string& end) {
  return text.size() >= end.size() && text.compare(text.size() - end.size(), end.size(), end) == 0;
}

// Calls visit(begin, end) for each longest run of characters of a kind.
void EachRun(const std::string& text, bool (*kind)(char), const std::function<void(std::size_t, std::size_t)>& visit) {
  for (std::size_t end = 0, begin = 0; begin < text.size(); begin = end + 1) {
    for (end = begin; end < text.size() && kind(text[end]);) ++end;
    if (end > begin) visit(begin, end);
  }
}

struct Known {
  std::unordered_set<std::string> identifiers;
  std::set<std::string> paths;               // of files and folders, from the root
  std::unordered_set<std::string> suffixes;  // of paths and of included headers, from any folder on

  void AddPath(const std::string& path) {
    paths.insert(path);
    AddSuffixes(path);
  }
  void AddSuffixes(const std::string& path) {
    suffixes.insert(path);
    for (std::size_t at = path.find('/'); at != std::string::npos; at = path.find('/', at + 1))
      suffixes.insert(path.substr(at + 1));
  }
  void AddCode(const std::string& code) {
    EachRun(code, &IsWord,
            [&](std::size_t begin, std::size_t end) { identifiers.insert(code.substr(begin, end - begin)); });
    for (const std::string& header : HeadersOf(code)) AddSuffixes(header);
  }

  // "docs/decisions/0020" and "heat" of "heat.{h,cc}" stand for what begins so.
  bool HasPath(const std::string& path) const {
    const auto at = paths.lower_bound(path);
    if (at == paths.end() || at->compare(0, path.size(), path) != 0) return false;
    return at->size() == path.size() || (*at)[path.size()] == '.' || (*at)[path.size()] == '-';
  }
};

// A file of code, documentation or settings, and whether its name says which of ours it may be.
bool IsFileName(const std::string& word, bool is_path) {
  for (const char* end : {".h", ".cc", ".ts", ".cmake"}) {
    if (Ends(word, end)) return true;
  }
  return is_path && (Ends(word, ".md") || Ends(word, ".py") || Ends(word, ".toml") || Ends(word, ".json"));
}

// "docs/NAME.md": a part is to be replaced.
bool IsPlaceholder(const std::string& path) {
  bool found = false;
  EachRun(
      path, [](char c) { return Is(std::isalnum, c); },
      [&](std::size_t begin, std::size_t end) {
        const std::string part = path.substr(begin, end - begin);
        found = found || part == "NAME" || part == "TOPIC" || part == "MODULE" || part == "ROOT";
      });
  return found;
}

bool IsMissingPath(const std::string& word, const Known& known, bool others) {
  const std::size_t slash = word.find('/');
  if (slash == std::string::npos) return !others && IsFileName(word, false) && known.suffixes.count(word) == 0;
  const std::string top = word.substr(0, slash);
  if (IsPlaceholder(word)) return false;
  if (std::find(kTops.begin(), kTops.end(), top) != kTops.end()) return !known.HasPath(word);
  return !others && kInstalled.count(top) == 0 && IsFileName(word, true) && known.suffixes.count(word) == 0;
}

// At least two words, "ContactScene": not "Contact", "USB" or "OpenXR".
bool IsCamelCase(const std::string& word) {
  int humps = 0;
  for (std::size_t i = 0; i < word.size(); ++i) {
    if (!Is(std::isalnum, word[i])) return false;
    if (Is(std::isupper, word[i]) && (i + 1 == word.size() || !Is(std::islower, word[i + 1]))) return false;
    humps += Is(std::isupper, word[i]) ? 1 : 0;
  }
  return humps > 1 && Is(std::isupper, word[0]);
}

bool IsConstant(const std::string& word) { return word.size() > 2 && word[0] == 'k' && Is(std::isupper, word[1]); }

// What the text names and the repository does not have.
std::vector<std::string> Missing(const std::string& text, const Known& known, bool is_document, bool others = false) {
  std::vector<std::string> missing;
  bool is_code = false, is_quoted = false;  // between ` or "
  std::size_t seen = 0, cited = 0;          // cited: end of [a citation]
  const auto is_run = [](char c) { return IsWord(c) || c == '.' || c == '/' || c == ':' || c == '-' || c == '+'; };
  EachRun(text, is_run, [&](std::size_t begin, std::size_t end) {
    for (; seen < begin; ++seen) {
      if (text[seen] == '`') is_code = !is_code;
      if (text[seen] == '"') is_quoted = !is_quoted;
      if (text.compare(seen, 2, "\n\n") == 0) is_code = is_quoted = false;
      if (text[seen] == '[' && seen >= cited) {
        const std::size_t close = text.find_first_of("[]", seen + 1);
        if (close != std::string::npos && text[close] == ']') cited = close;
      }
    }
    std::string word = text.substr(begin, end - begin);
    const bool is_called = text.compare(end, 2, "()") == 0;
    const char before = begin > 0 ? text[begin - 1] : ' ', after = end < text.size() ? text[end] : ' ';
    while (!word.empty() && !IsWord(word.back())) word.pop_back();
    const bool cut = word.empty() || !IsWord(word[0]) || word.find("//") != std::string::npos ||
                     std::string("~$<{*@%}").find(before) != std::string::npos;
    if (cut || (begin < cited && !is_document)) return;
    const bool is_path = word.find('/') != std::string::npos;
    const bool goes_on = std::string("*<$").find(after) != std::string::npos && (is_path || IsWord(text[end - 1]));
    if (goes_on || kNotOurs.count(word) != 0) return;
    if (IsMissingPath(word, known, others)) missing.push_back(word);
    if (is_path || IsFileName(word, false) || is_quoted) return;
    const bool is_name =
        is_called || word.find("::") != std::string::npos || (before == '`' && after == '`' && !is_document);
    EachRun(word, &IsWord, [&](std::size_t from, std::size_t to) {
      const std::string name = word.substr(from, to - from);
      const bool checked = is_name || IsConstant(name) || (IsCamelCase(name) && (is_code || !is_document));
      if (checked && known.identifiers.count(name) == 0 && kNotOurs.count(name) == 0) missing.push_back(name);
    });
  });
  return missing;
}

// Without comments that begin with '#'.
std::string WithoutHashes(const std::string& text) {
  std::istringstream lines(text);
  std::string code;
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find_first_not_of(" \t");
    if (at != std::string::npos && line[at] != '#') code += line + "\n";
  }
  return code;
}

TEST(Names, ThoseInCommentsAndDocumentsExist) {
  const std::string root = OMNI_SOURCE_DIR;
  Known known;
  for (const std::string& top : kTops) {
    for (fs::recursive_directory_iterator at(fs::path(root) / top), end; at != end; ++at) {
      if (at->path().filename() == "node_modules") at.disable_recursion_pending();
      known.AddPath(at->path().generic_string().substr(root.size() + 1));
    }
    known.AddPath(top);
  }
  for (const auto& [path, text] : ReadTree(root, kTops, {"", ".cmake", ".json", ".mjs", ".py", ".sh", ".toml", ".txt"}))
    known.AddCode(Ends(path, ".json") || Ends(path, ".mjs") ? text : WithoutHashes(text));
  SourceTree comments;
  for (const auto& [path, text] : ReadTree(root, kTops, {".c", ".cc", ".cpp", ".h", ".ts"})) {
    const Source source = ReadSource(text);
    known.AddCode(source.code);
    if (path.compare(0, 6, "tests/") == 0) continue;
    for (const Comment& comment : source.comments) comments[path] += comment.text + "\n\n";
  }
  ASSERT_GT(comments.size(), 800U) << "the sources were found";
  for (const auto& [path, text] : comments) {
    for (const std::string& missing : Missing(text, known, false)) ADD_FAILURE() << path << ": there is no " << missing;
  }
  for (const auto& [path, text] : ReadTree(root, {"docs", "firmware", "layer"}, {".md"})) {
    if (path.compare(0, 15, "docs/benchmarks") == 0) continue;  // they keep names of their time
    for (const std::string& missing : Missing(text, known, true, path == kOtherSources))
      ADD_FAILURE() << path << ": there is no " << missing;
  }
}

TEST(Names, MissingOnesAreFound) {
  Known known;
  for (const char* path : {"service", "service/loop", "service/loop/tick.h", "service/loop/heat.cc", "docs",
                           "docs/decisions/0020-a-base.md"})
    known.AddPath(path);
  known.AddCode("#include <openxr/openxr.h>\nclass LoopState { int kMost; }; void Step(); namespace base {}");
  using Words = std::vector<std::string>;
  const std::string fine =
      "A LoopState of at most kMost, Step(), base::Step, service/loop/tick.h (tick.h, loop/heat.{h,cc}), docs/NAME.md, "
      "docs/decisions/0020, service/loop/*.cc, openxr.h, https://a.b/SomeName/x.h, OpenXR [OtherName, b.cc], x in [0, "
      "1), rule "
      "\"RuleName\", an XrEvent* structure.";
  EXPECT_EQ(Missing(fine, known, false), Words{});
  EXPECT_EQ(Missing("see service/loop/tock.h and loop/tock.h, tock.cc", known, false),
            (Words{"service/loop/tock.h", "loop/tock.h", "tock.cc"}));
  EXPECT_EQ(Missing("service/twin, docs/decisions/0021", known, false), (Words{"service/twin", "docs/decisions/0021"}));
  EXPECT_EQ(Missing("x in [0, 1): kLeast, Stop(), base::Stop, a LoopWatch", known, false),
            (Words{"kLeast", "Stop", "Stop", "LoopWatch"}));
  EXPECT_EQ(Missing("`most_N` of `LoopState`", known, false), Words{"most_N"});
  EXPECT_EQ(Missing("SteamVR's LoopWatch, in `LoopWatch.*`", known, true), Words{"LoopWatch"});
}

}  // namespace
}  // namespace omni::architecture
