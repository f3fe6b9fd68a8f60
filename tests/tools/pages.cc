// Manual pages and completions name everything that --help does; bash's is run.
#include "service/console/pages.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "service/daemon/run.h"
#include "service/tools/common/command_line.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_pages {

using console::CommandText;
using console::OptionText;

CommandText OfOmni() {
  console::Program omni("omni", kOmniAbout, "test");
  AddCommands(omni);
  return omni.Describe();
}

CommandText OfOmnid() {
  console::Program omnid("omnid", daemon::kOmnidAbout, "test");
  daemon::RunOptions options;
  daemon::AddOptions(omnid, options);
  return omnid.Describe();
}

void Walk(const CommandText& command, const std::string& path,
          const std::function<void(const CommandText&, const std::string&)>& visit) {
  visit(command, path);
  for (const CommandText& below : command.commands) Walk(below, path + " " + below.name, visit);
}

TEST(Describe, HasEveryCommandAndNoHiddenOne) {
  const CommandText omni = OfOmni();
  std::vector<std::string> names;
  for (const CommandText& command : omni.commands) names.push_back(command.name);
  for (const char* name : {"setup", "try", "monitor", "scene", "align"}) {
    EXPECT_NE(std::find(names.begin(), names.end(), name), names.end()) << name;
  }
  EXPECT_EQ(std::find(names.begin(), names.end(), "bench"), names.end());
  EXPECT_EQ(std::find(names.begin(), names.end(), "rehearse-controller"), names.end());
}

TEST(Pages, NameEveryOption) {
  for (const CommandText& program : {OfOmni(), OfOmnid()}) {
    const std::string bash = console::BashCompletion(program), zsh = console::ZshCompletion(program);
    const std::string fish = console::FishCompletion(program);
    const std::string page = console::ManPage(program, program.name, "", "Omni test");
    Walk(program, program.name, [&](const CommandText& command, const std::string& path) {
      EXPECT_FALSE(command.about.empty()) << path;
      for (const OptionText& option : command.options) {
        for (const std::string& name : option.names) {
          SCOPED_TRACE(path + " " + name);
          EXPECT_NE(bash.find(name), std::string::npos);
          EXPECT_NE(zsh.find("'" + name + ":"), std::string::npos);
          const std::string bare = name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
          EXPECT_NE(fish.find(bare), std::string::npos);
          EXPECT_NE(page.find(name.substr(1)), std::string::npos);
        }
      }
    });
  }
}

// What bash offers for the words so far, the last of which is being typed.
std::string Offered(const std::vector<std::string>& words) {
  const test::TempFolder folder;
  folder.Write("completion", console::BashCompletion(OfOmni()));
  std::string typed;
  for (const std::string& word : words) typed += " '" + word + "'";
  const std::string script = "cd '" + folder.Path() + "'; . ./completion; COMP_WORDS=(" + typed +
                             "); COMP_CWORD=" + std::to_string(words.size() - 1) +
                             "; _omni; printf '%s ' \"${COMPREPLY[@]}\"";
  folder.Write("script", script);
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> out(
      ::popen(("bash '" + folder.Path("script") + "' 2>&1").c_str(), "r"), ::pclose);
  std::string text;
  char part[256];
  while (std::fgets(part, sizeof(part), out.get()) != nullptr) text += part;
  return text;
}

TEST(BashCompletion, OffersWhatMayFollow) {
  EXPECT_EQ(Offered({"omni", "mo"}), "monitor ");
  EXPECT_EQ(Offered({"omni", "scene", "ex"}), "explain ");
  EXPECT_EQ(Offered({"omni", "align", "--hand", ""}), "auto left right ");
  EXPECT_EQ(Offered({"omni", "align", "--ha"}), "--hand ");
  EXPECT_EQ(Offered({"omni", "monitor", "--port", ""}), " ") << "a number";
  EXPECT_NE(Offered({"omni", "scene", "explain", "comp"}).find("completion"), std::string::npos) << "a file";
}

}  // namespace test_tools_pages
}  // namespace omni::tools
