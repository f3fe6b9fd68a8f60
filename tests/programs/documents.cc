// Commands named in the documents exist with their options: each is looked up in the program's own --help.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "service/protocol/control.h"
#include "service/protocol/message_table.h"
#include "tests/support/process/program.h"

namespace omni::test {
namespace test_programs_documents {

namespace fs = std::filesystem;

struct CodeText {
  std::string where;  // file:line
  std::string text;
};

// Code of a Markdown text: fenced and indented lines whole, and text between single backticks.
std::vector<CodeText> CodeIn(const std::string& file) {
  std::ifstream stream(file);
  std::vector<CodeText> found;
  bool fenced = false, was_blank = true, indented = false;
  int number = 0;
  for (std::string line; std::getline(stream, line);) {
    const std::string where =
        fs::path(file).lexically_relative(OMNI_SOURCE_DIR).string() + ":" + std::to_string(++number);
    if (line.starts_with("```")) {
      fenced = !fenced;
      continue;
    }
    indented = line.starts_with("    ") && (was_blank || indented);
    was_blank = line.empty();
    if (fenced || indented) {
      found.push_back({where, line});
      continue;
    }
    for (std::size_t open = line.find('`'); open != line.npos;) {
      const std::size_t close = line.find('`', open + 1);
      if (close == line.npos) break;
      found.push_back({where, line.substr(open + 1, close - open - 1)});
      open = line.find('`', close + 1);
    }
  }
  return found;
}

// The words of each command in a line of a shell, without comments, brackets of what may be left out, and quotes.
std::vector<Words> CommandsIn(std::string text) {
  if (const std::size_t comment = text.find(" #"); comment != text.npos) text.resize(comment);
  std::vector<Words> commands(1);
  std::string word;
  const auto end_word = [&] {
    if (word == "--") commands.emplace_back();  // omni_hil: another program follows
    if (!word.empty() && word != "--") commands.back().push_back(word);
    word.clear();
  };
  for (const char c : text) {
    const bool separates = c == '|' || c == ';' || c == '&' || c == '(' || c == ')';
    if (c == ' ' || separates) end_word();
    if (separates) commands.emplace_back();
    if (c != ' ' && !separates && std::string("[]\"'`,").find(c) == std::string::npos) word += c;
  }
  end_word();
  return commands;
}

// Help of a program or of one of its commands, cached.
const std::string& HelpOf(const Words& path) {
  static std::map<Words, std::string> known;
  const auto [found, fresh] = known.try_emplace(path);
  if (fresh) {
    Words words = path;
    words[0] = BinaryPath(words[0]);
    words.emplace_back("--help");
    found->second = RunProgram(words).out;
  }
  return found->second;
}

std::string Joined(const Words& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : " ") + word;
  return text;
}

bool HasOption(const std::string& help, const std::string& option) {
  for (std::size_t at = help.find(option); at != help.npos; at = help.find(option, at + 1)) {
    const char before = at == 0 ? ' ' : help[at - 1];
    const char after = at + option.size() < help.size() ? help[at + option.size()] : ' ';
    const bool goes_on = std::isalnum(static_cast<unsigned char>(after)) != 0 || after == '-';
    if ((before == ' ' || before == ',') && !goes_on) return true;
  }
  return false;
}

bool IsCommandWord(const std::string& word) {
  return !word.empty() &&
         std::all_of(word.begin(), word.end(), [](char c) { return (c >= 'a' && c <= 'z') || c == '-'; });
}

bool IsOurs(const std::string& program) {
  const auto programs = {"omni", "omnid", "omni-twin", "omni-bench", "scene_render", "omni_hil"};
  return std::find(programs.begin(), programs.end(), program) != programs.end();
}

// The command or option that does not exist; empty: all exist. words[0]: the program.
std::string ProblemWith(const Words& words) {
  Words path{words[0]};
  std::size_t next = 1;
  while (next < words.size() && IsCommandWord(words[next]) && words[next][0] != '-') {
    const bool has_commands = HelpOf(path).find("SUBCOMMAND") != std::string::npos;
    if (!has_commands) break;
    path.push_back(words[next++]);
    if (HelpOf(path).find("Usage: " + Joined(path)) == std::string::npos) return "there is no " + Joined(path);
  }
  for (; next < words.size(); ++next) {
    std::string option = words[next].substr(0, words[next].find('='));
    const bool is_option =
        option.size() > 1 && option[0] == '-' && std::isalpha(static_cast<unsigned char>(option.back())) != 0;
    if (is_option && !HasOption(HelpOf(path), option)) return Joined(path) + " has no " + option;
  }
  return {};
}

std::vector<std::string> Documents() {
  std::vector<std::string> files;
  for (const char* name : {"README.md", "SECURITY.md", "firmware/README.md"}) {
    files.push_back(std::string(OMNI_SOURCE_DIR) + "/" + name);
  }
  for (const auto& entry : fs::recursive_directory_iterator(OMNI_SOURCE_DIR "/docs")) {
    if (entry.path().extension() == ".md") files.push_back(entry.path().string());
  }
  return files;
}

TEST(Documents, EveryCommandInDocsExistsWithItsOptions) {
  std::size_t commands = 0;
  std::string problems;
  for (const std::string& file : Documents()) {
    for (const CodeText& code : CodeIn(file)) {
      for (Words words : CommandsIn(code.text)) {
        while (!words.empty() && words[0].find('=') != std::string::npos) words.erase(words.begin());
        if (!words.empty() && words[0] == "$") words.erase(words.begin());
        if (words.empty()) continue;
        words[0] = fs::path(words[0]).filename().string();
        if (!IsOurs(words[0]) || !fs::exists(BinaryPath(words[0]))) continue;
        ++commands;
        if (const std::string problem = ProblemWith(words); !problem.empty()) {
          problems += code.where + ": " + problem + " in `" + code.text + "`\n";
        }
      }
    }
  }
  std::printf("[ figure   ] %zu commands are named in the documents\n", commands);
  EXPECT_EQ(problems, "");
  EXPECT_GT(commands, 150U) << "the documents are found and read";
}

std::string WholeText(const std::string& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(Documents, EveryLinkLeadsToAFile) {
  const std::regex link(R"(\]\(([^)#\s]+)[^)]*\))");
  std::string broken;
  for (const std::string& file : Documents()) {
    const std::string text = WholeText(file);
    for (std::sregex_iterator at(text.begin(), text.end(), link), end; at != end; ++at) {
      const std::string target = (*at)[1];
      if (target.starts_with("http")) continue;
      if (!fs::exists(fs::path(file).parent_path() / target)) broken += file + ": " + target + "\n";
    }
  }
  EXPECT_EQ(broken, "");
}

// "The socket's protocol is version 4": wherever the control protocol's version is stated; in the changelog the newest
// statement, which is the first.
TEST(Documents, StatedProtocolVersionMatchesTheCode) {
  const std::regex said(R"(protocol (?:has|is) version (\d+))");
  std::vector<std::string> files = Documents();
  files.emplace_back(OMNI_SOURCE_DIR "/CHANGELOG.md");
  int found = 0;
  for (const std::string& file : files) {
    const std::string text = std::regex_replace(WholeText(file), std::regex("\\s+"), " ");
    for (std::sregex_iterator at(text.begin(), text.end(), said), end; at != end; ++at) {
      ++found;
      EXPECT_EQ((*at)[1], std::to_string(protocol::kProtocolVersion)) << file;
      if (file.ends_with("CHANGELOG.md")) break;
    }
  }
  EXPECT_GE(found, 1);
}

// "| Hello | client, first |": each message of the table is in the first column of one of docs/protocol/ipc.md.
TEST(Documents, EveryMessageIsDescribed) {
  const std::string text = WholeText(OMNI_SOURCE_DIR "/docs/protocol/ipc.md");
#define OMNI_DESCRIBED(name, ...) \
  EXPECT_TRUE(std::regex_search(text, std::regex("\\n\\|[^|]*\\b" #name "\\b"))) << #name;
  OMNI_LINK_MESSAGES(OMNI_DESCRIBED)
  OMNI_REQUESTS(OMNI_DESCRIBED)
  OMNI_SERVER_MESSAGES(OMNI_DESCRIBED)
#undef OMNI_DESCRIBED
}

TEST(Documents, CheckerDetectsUnknownCommandsAndOptions) {
  EXPECT_EQ(ProblemWith({"omni", "scene", "explain", "dragon", "--fit"}), "");
  EXPECT_EQ(ProblemWith({"omni", "scene", "explode", "dragon"}), "there is no omni scene explode");
  EXPECT_EQ(ProblemWith({"omni", "scene", "explain", "--tou"}), "omni scene explain has no --tou");
  EXPECT_EQ(ProblemWith({"omnid", "--device", "twin", "--fast"}), "omnid has no --fast");
  EXPECT_EQ(CommandsIn("A=b omni scene cache [--clear] # all | omnid").size(), 1U);
  EXPECT_EQ(CommandsIn("omni_hil --fast -- omnid --device usb"),
            (std::vector<Words>{{"omni_hil", "--fast"}, {"omnid", "--device", "usb"}}));
}

}  // namespace test_programs_documents
}  // namespace omni::test
