// Mistyped words, wrapped text and command lines: parts shared by all our programs.
#include <gtest/gtest.h>
#include <stdlib.h>

#include <algorithm>
#include <cstdint>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "service/base/files/nearest_word.h"
#include "service/console/command.h"
#include "service/console/wrap.h"

namespace omni::console {
namespace test_console_words {

const std::vector<std::string> kWords = {"status", "watch", "doctor", "scene", "surfaces", "report"};

TEST(NearestWord, FindsTheIntendedWordForTypos) {
  const struct {
    const char *typed, *meant;
  } rows[] = {{"statsu", "status"},    {"sttaus", "status"}, {"Status", "status"}, {"statuss", "status"},
              {"stat", "status"},      {"wach", "watch"},    {"scnee", "scene"},   {"docter", "doctor"},
              {"surface", "surfaces"}, {"repor", "report"}};
  for (const auto& row : rows) EXPECT_EQ(base::NearestWord(row.typed, kWords), row.meant) << row.typed;
}

TEST(NearestWord, IsEmptyWhenNoWordIsSimilar) {
  for (const char* typed : {"", "x", "dance", "sculpture", "st", "--json"}) {
    EXPECT_EQ(base::NearestWord(typed, kWords), "") << typed;
  }
  EXPECT_EQ(base::NearestWord(std::string(10'000'000, 's'), kWords), "");  // NOLINT(bugprone-string-constructor)
  EXPECT_EQ(base::NearestWord("status", std::vector<std::string>{}), "");
}

TEST(NearestWord, DistanceIsSymmetricAndZeroForEqualWordsOnly) {
  for (const std::string& a : kWords) {
    for (const std::string& b : kWords) {
      EXPECT_EQ(base::EditDistance(a, b), base::EditDistance(b, a));
      EXPECT_EQ(base::EditDistance(a, b) == 0, a == b);
    }
  }
  EXPECT_EQ(base::EditDistance("abcd", "abdc"), 1U) << "a swap is one slip";
  EXPECT_EQ(base::EditDistance("", "abc"), 3U);
}

std::vector<std::string> WordsOf(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

std::size_t Widest(const std::string& text) {
  std::istringstream stream(text);
  std::size_t widest = 0;
  for (std::string line; std::getline(stream, line);) {
    if (WordsOf(line).size() > 1) widest = std::max(widest, line.size());
  }
  return widest;
}

constexpr const char* kStatus =
    "omnid      0.1.0, pid 7, up 0:00:01\n"
    "tick       1000 ticks, 0 late; median 12.0 us, p99 20.0 us, max 31.5 us; the base applies new currents 600 us "
    "after\n"
    "problem    /a/very/long/path/that/nobody/can/break/anywhere/at/all/scene.glb: cannot be opened\n"
    "\n"
    "  --seconds FLOAT    how long it goes on, in seconds of the base's own clock\n";

TEST(Wrap, KeepsWidthAndAllWords) {
  for (int columns = 20; columns <= 200; ++columns) {
    const std::string wrapped = Wrap(kStatus, columns);
    EXPECT_LE(Widest(wrapped), static_cast<std::size_t>(columns)) << wrapped;
    EXPECT_EQ(WordsOf(wrapped), WordsOf(kStatus));
  }
  EXPECT_EQ(Wrap(kStatus, 200), kStatus);
  EXPECT_EQ(Wrap(kStatus, 0), kStatus);
}

TEST(Wrap, IndentsContinuationLinesToTextColumn) {
  EXPECT_EQ(Wrap("tick       one two three\n", 20), "tick       one two\n  three\n") << "no room for a column";
  EXPECT_EQ(Wrap("tick    one two three four five\n", 20), "tick    one two\n        three four\n        five\n");
  EXPECT_EQ(Wrap("    an indented line of words\n", 20), "    an indented line\n    of words\n");
  EXPECT_EQ(Wrap("a line of words that is long\n", 20), "a line of words that\n  is long\n");
  EXPECT_EQ(Wrap("umlauts \xC3\xA4\xC3\xB6\xC3\xBC count\n", 21), "umlauts \xC3\xA4\xC3\xB6\xC3\xBC count\n");
}

TEST(Wrap, WidthPrefersColumnsVariable) {
  ::setenv("COLUMNS", "64", 1);
  EXPECT_EQ(TextColumns(0), 64);
  ::setenv("COLUMNS", "3", 1);
  EXPECT_EQ(TextColumns(0), 20);
  for (const char* wrong : {"", "wide", "-1", "80x", "99999999999"}) {
    ::setenv("COLUMNS", wrong, 1);
    EXPECT_EQ(TextColumns(-1), 0) << "no terminal: " << wrong;
  }
  ::unsetenv("COLUMNS");
  EXPECT_EQ(TextColumns(-1), 0);
}

struct Parsed {
  std::optional<int> status;
  std::string out, err;
};

Parsed ParseWords(const std::vector<std::string>& words) {
  Program tool("tool", "tool: does things", "1.2");
  std::string colour, file;
  int count = 0;
  Command paint = tool.AddCommand("paint", "paints");
  paint.Add("--colour", colour).OneOf({"red", "green", "blue"});
  paint.Add("--count", count);
  paint.Add("file", file).WritesOnly(".png", "PNG");
  tool.AddCommand("wait", "waits").SetAction([] { return 3; });
  tool.RequireCommand();
  testing::internal::CaptureStdout();
  testing::internal::CaptureStderr();
  Parsed parsed{.status = tool.Parse(words)};
  parsed.out = testing::internal::GetCapturedStdout();
  parsed.err = testing::internal::GetCapturedStderr();
  return parsed;
}

TEST(Parse, ErrorsNameWrongWordAndSuggestNearest) {
  const struct {
    std::vector<std::string> words;
    const char* said;
  } rows[] = {
      {{"pant"}, "tool: there is no command 'pant'; did you mean 'paint'?\n"},
      {{"xyz"}, "tool: there is no command 'xyz'; there are paint, wait\n"},
      {{}, "tool: a command is missing; there are paint, wait\n"},
      {{"--verison"}, "tool: there is no option '--verison'; did you mean '--version'?\n"},
      {{"paint", "--color", "red"}, "tool paint: there is no option '--color'; did you mean '--colour'?\n"},
      {{"paint", "--color=red"}, "tool paint: there is no option '--color'; did you mean '--colour'?\n"},
      {{"paint", "--fast"}, "tool paint: there is no option '--fast'; 'tool paint --help' lists them\n"},
      {{"paint", "--colour", "bleu"},
       "tool paint: --colour: 'bleu' is none of red, green, blue; did you mean 'blue'?\n"},
      {{"paint", "a.png", "b.png"}, "tool paint: 'b.png' is a word too many; see 'tool paint --help'\n"},
      {{"paint", "a.jpg"},
       "tool paint: file: 'a.jpg' does not end in .png, and PNG is all that is written; take a.png\n"},
      {{"paint", "--count", "many"}, "tool paint: could not convert: --count = many; see 'tool paint --help'\n"},
  };
  for (const auto& row : rows) {
    const Parsed parsed = ParseWords(row.words);
    EXPECT_EQ(parsed.status, kExitUsage);
    EXPECT_EQ(parsed.err, row.said);
    EXPECT_EQ(parsed.out, "");
  }
}

TEST(Parse, ValidWordsReturnTheCommandsStatus) {
  EXPECT_EQ(ParseWords({"paint", "--colour", "red", "a.png"}).status, std::nullopt);
  EXPECT_EQ(ParseWords({"wait"}).status, 3);
  EXPECT_EQ(ParseWords({"--version"}).status, 0);
  EXPECT_EQ(ParseWords({"--version"}).out, "tool 1.2\n");
  const Parsed help = ParseWords({"paint", "--help"});
  EXPECT_EQ(help.status, 0);
  EXPECT_NE(help.out.find("--colour"), std::string::npos) << help.out;
  EXPECT_EQ(help.err, "");
}

TEST(Parse, CommandsGetTheirArguments) {
  struct Arguments {
    bool quiet = true;
    int count = 1;
    std::uint64_t seed = 2;
    std::vector<double> place;
    std::vector<std::string> names;
    std::string colour;
  };
  const auto run = [](std::vector<std::string> words) {
    Program tool("tool", "tool: does things");
    tool.RequireCommand();
    auto arguments = std::make_shared<Arguments>();
    Command paint = tool.AddCommand("paint", "paints");
    paint.Add("!--loud", arguments->quiet);
    Option count = paint.Add("-c,--count", arguments->count).Range(1, 9);
    paint.Add("--seed", arguments->seed).Needs(count);
    paint.Add("--place", arguments->place).ExpectValues(2).Excludes(count);
    Option colour = paint.Add("--colour", arguments->colour);
    paint.AddShort("--red", arguments->colour, "red", "short for --colour red").Excludes(colour);
    paint.Add("names", arguments->names);
    paint.SetAction(arguments, [](const Arguments& given) {
      const double sum = given.place.empty() ? 0 : given.place[0] + given.place[1];
      return static_cast<int>(sum) + (given.quiet ? 1000 : 0) + 100 * given.count + 10 * static_cast<int>(given.seed) +
             (given.colour == "red" ? 5000 : 0) + static_cast<int>(given.names.size());
    });
    tool.AddHidden("draw").SetAction([count] { return count.given() ? 1 : 7; });
    return tool.Parse(std::move(words));
  };
  EXPECT_EQ(run({"paint"}), 1120);
  EXPECT_EQ(run({"paint", "a", "-c", "9", "b", "--seed", "3", "--loud"}), 932);
  EXPECT_EQ(run({"paint", "--place", "1.5", "2.5"}), 1124);
  EXPECT_EQ(run({"paint", "--red"}), 6120);
  EXPECT_EQ(run({"paint", "--colour", "red"}), 6120);
  EXPECT_EQ(run({"draw", "--anything", "at", "--help"}), 7);
  testing::internal::CaptureStderr();
  EXPECT_EQ(run({"paint", "-c", "10"}), kExitUsage);
  EXPECT_EQ(run({"paint", "--seed", "3"}), kExitUsage);
  EXPECT_EQ(run({"paint", "-c", "3", "--place", "1", "2"}), kExitUsage);
  EXPECT_EQ(run({"paint", "--red", "--colour", "blue"}), kExitUsage);
  EXPECT_EQ(testing::internal::GetCapturedStderr(),
            "tool paint: --count: Value 10 not in range 1 to 9\n"
            "tool paint: --seed requires --count; see 'tool paint --help'\n"
            "tool paint: --count excludes --place; see 'tool paint --help'\n"
            "tool paint: --colour excludes --red; see 'tool paint --help'\n");
}

}  // namespace test_console_words
}  // namespace omni::console
