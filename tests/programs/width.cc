// Texts on terminals of 40, 80 and 200 columns: nothing is wider, nothing is lost.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/support/process/program.h"
#include "tests/support/process/service_process.h"

namespace omni::test {
namespace test_programs_width {

std::vector<std::string> WordsIn(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

// Lines that are too wide, but for those of one word.
std::string TooWide(const std::string& text, std::size_t columns) {
  std::istringstream stream(text);
  std::string wide;
  for (std::string line; std::getline(stream, line);) {
    if (line.size() > columns && WordsIn(line).size() > 1) wide += line + "\n";
  }
  return wide;
}

// The same words on each terminal as in a pipe, where `stable` lines stay as they are.
void ExpectFits(const Words& words, const Words& environment) {
  const Ran piped = RunProgram(words, environment);
  const std::vector<std::string> expected = WordsIn(piped.out + piped.err);
  ASSERT_FALSE(expected.empty());
  for (const int columns : {40, 80, 200}) {
    const Ran shown = RunOnTerminal(words, columns, environment);
    EXPECT_EQ(shown.status, piped.status);
    EXPECT_EQ(TooWide(shown.out, static_cast<std::size_t>(columns)), "") << columns << " columns: " << words[1];
    EXPECT_EQ(WordsIn(shown.out), expected) << columns << " columns:\n" << shown.out;
  }
}

class OnTerminals : public testing::Test {
 protected:
  Words Omni(const Words& words) const {
    Words all{BinaryPath("omni")};
    all.insert(all.end(), words.begin(), words.end());
    return all;
  }
  Words environment() const {
    return {"OMNI_SOCKET=" + folder_.Path("run/omnid.sock"), "XDG_CACHE_HOME=" + folder_.Path("cache"), "TERM=xterm"};
  }
  const TempFolder folder_;
};

TEST_F(OnTerminals, HelpOfEveryProgramFits) {
  for (const char* program : {"omnid", "omni-twin", "omni-bench", "scene_render", "omni_hil"}) {
    if (std::filesystem::exists(BinaryPath(program))) ExpectFits({BinaryPath(program), "--help"}, environment());
  }
}

// [no-color.org]
TEST_F(OnTerminals, LogIsColouredUnlessNoColorIsSet) {
  std::filesystem::create_directories(folder_.Path("run"));
  std::filesystem::permissions(folder_.Path("run"), std::filesystem::perms::owner_all);
  const Words words{"/usr/bin/timeout", "--foreground", "1", BinaryPath("omnid"), "--device", "twin"};
  for (const auto& [setting, coloured] : {std::pair("NO_COLOR=", true), std::pair("NO_COLOR=1", false)}) {
    Words with = environment();
    with.emplace_back(setting);
    const Ran ran = RunOnTerminal(words, 80, with);
    EXPECT_NE(ran.out.find("SIMULATION"), std::string::npos) << ran.out;
    EXPECT_EQ(ran.out.find("\033[") != std::string::npos, coloured) << setting << ": " << ran.out;
  }
}

TEST_F(OnTerminals, HelpOfEveryCommandFits) {
  for (const Words& command : std::vector<Words>{{},
                                                 {"scene"},
                                                 {"scene", "explain"},
                                                 {"scene", "save"},
                                                 {"surfaces"},
                                                 {"align"},
                                                 {"follow"},
                                                 {"track"},
                                                 {"twin", "run"},
                                                 {"report"},
                                                 {"device"}}) {
    Words words = Omni(command);
    words.emplace_back("--help");
    ExpectFits(words, environment());
  }
}

TEST_F(OnTerminals, ErrorsFit) {
  for (const Words& words :
       std::vector<Words>{{"statsu"}, {"dance"}, {"status"}, {"scene", "explain", "dargon"}, {"report"}}) {
    ExpectFits(Omni(words), environment());
  }
}

TEST_F(OnTerminals, DoctorFits) { ExpectFits(Omni({"doctor"}), environment()); }

TEST_F(OnTerminals, ExplainFits) {
  RunProgram(Omni({"scene", "explain", "dragon"}), environment());  // into the cache: times differ otherwise
  const Ran piped = RunProgram(Omni({"scene", "explain", "dragon"}), environment());
  for (const int columns : {40, 80, 200}) {
    const Ran shown = RunOnTerminal(Omni({"scene", "explain", "dragon"}), columns, environment());
    EXPECT_EQ(TooWide(shown.out, static_cast<std::size_t>(columns)), "");
    EXPECT_EQ(WordsIn(shown.out).size(), WordsIn(piped.out).size()) << "but for the times the words are the same";
  }
}

TEST_F(OnTerminals, StatusFits) {
  ServiceProcess service;
  service.Start();
  const Words environment{"OMNI_SOCKET=" + service.socket_path()};
  const auto has_device = [&] {
    return RunProgram(Omni({"status"}), environment).out.find("simulation") != std::string::npos;
  };
  for (int i = 0; i < 200 && !has_device(); ++i) SleepMs(50);
  for (const int columns : {40, 80, 200}) {
    const Ran shown = RunOnTerminal(Omni({"status"}), columns, environment);
    EXPECT_EQ(shown.status, 0) << shown.out;
    EXPECT_EQ(TooWide(shown.out, static_cast<std::size_t>(columns)), "");
    for (const char* word :
         {"omnid", "device", "simulation", "calibrated", "tick", "median", "pen", "force", "client"}) {
      EXPECT_NE(shown.out.find(word), std::string::npos) << word << " at " << columns << " columns";
    }
  }
}

TEST_F(OnTerminals, JsonIsNeverWrapped) {
  const Ran piped = RunProgram(Omni({"scene", "explain", "dragon", "--json"}), environment());
  const Ran shown = RunOnTerminal(Omni({"scene", "explain", "dragon", "--json"}), 40, environment());
  EXPECT_EQ(std::count(shown.out.begin(), shown.out.end(), '\n'), std::count(piped.out.begin(), piped.out.end(), '\n'));
}

TEST_F(OnTerminals, PipesAreNotWrappedUnlessColumnsIsSet) {
  const Words doctor = Omni({"doctor"});
  EXPECT_NE(TooWide(RunProgram(doctor, environment()).out, 100), "") << "a line a finding, for those who search";
  Words narrow = environment();
  narrow.emplace_back("COLUMNS=40");
  EXPECT_EQ(TooWide(RunProgram(doctor, narrow).out, 40), "");
  Words help = Omni({"align", "--help"});
  EXPECT_EQ(TooWide(RunProgram(help, environment()).out, 100), "");
}

}  // namespace test_programs_width
}  // namespace omni::test
