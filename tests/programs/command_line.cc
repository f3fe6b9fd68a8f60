// Command lines of all our programs: errors for wrong arguments, and the exit statuses documented in
// docs/howto/install.md.
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/support/process/program.h"

namespace omni::test {
namespace test_programs_command_line {

// Some are built only where their libraries are.
std::vector<std::string> Programs() {
  std::vector<std::string> programs;
  for (const char* name :
       {"omni", "omnid", "scene_render", "scene_generator", "pen_generator", "omni_probe", "omni_touch", "omni_force",
        "omni_block", "omni_align_probe", "omni-twin", "omni-bench", "omni_bench_layer", "omni_hil"}) {
    if (std::filesystem::exists(BinaryPath(name))) programs.emplace_back(name);
  }
  return programs;
}

TEST(ExitStatus, EveryProgramExits0ForHelpAnd2ForWrongArguments) {
  ASSERT_GE(Programs().size(), 8U);
  for (const std::string& program : Programs()) {
    const Ran help = RunProgram({BinaryPath(program), "--help"});
    EXPECT_EQ(help.status, 0) << program << ": " << help.err;
    EXPECT_NE(help.out, "") << program;
    EXPECT_EQ(help.err, "") << program;
    const Ran wrong = RunProgram({BinaryPath(program), "--no-such-option"});
    EXPECT_EQ(wrong.status, 2) << program << ": " << wrong.err;
    EXPECT_EQ(wrong.out, "") << program;
    EXPECT_NE(wrong.err, "") << program;
  }
}

TEST(ExitStatus, VersionIsPrintedByBothMainPrograms) {
  for (const char* program : {"omni", "omnid"}) {
    const Ran version = RunProgram({BinaryPath(program), "--version"});
    EXPECT_EQ(version.status, 0);
    EXPECT_EQ(version.out, std::string(program) + " " + OMNI_VERSION + "\n");
  }
}

TEST(ExitStatus, TwinFailsWithoutInheritedSocketOrFiles) {
  const struct {
    Words options;
    Words parts;
  } rows[] = {{{"--fd", "987"}, {"987", "omnid --device twin"}},
              {{"--fd", "2", "--script", "/no/such/script.json"}, {"/no/such/script.json"}},
              {{"--fd", "2", "--device", "/no/such/device.toml"}, {"/no/such/device.toml"}}};
  for (const auto& row : rows) {
    Words words{BinaryPath("omni-twin")};
    words.insert(words.end(), row.options.begin(), row.options.end());
    const Ran twin = RunProgram(words);
    EXPECT_EQ(twin.status, 1);
    EXPECT_EQ(std::count(twin.err.begin(), twin.err.end(), '\n'), 1) << twin.err;
    EXPECT_TRUE(twin.err.starts_with("omni-twin: ")) << twin.err;
    for (const std::string& part : row.parts) EXPECT_NE(twin.err.find(part), std::string::npos) << twin.err;
  }
}

TEST(ExitStatus, MistypedWordsExit2AndSuggestNearest) {
  const struct {
    Words words;
    const char* meant;
  } rows[] = {
      {{"omnid", "--devcie", "twin"}, "'--device'"},
      {{"omnid", "--device", "twni"}, "'twin'"},
      {{"omnid", "--device", "repaly:x"}, "'replay:FILE'"},
      {{"omnid", "--hand", "lfet"}, "'left'"},
      {{"omnid", "--log-level", "debgu"}, "'debug'"},
      {{"omni-twin", "--sede", "1"}, "'--seed'"},
      {{"omni", "record", "x.rec", "--device", "ubs"}, "'usb'"},
      {{"scene_render", "dragon", "x.png", "--view", "tpo"}, "'top'"},
      {{"omni_probe", "--profiles", "tuoch"}, "'touch'"},
      {{"omni_probe", "--sceonds", "1"}, "'--seconds'"},
  };
  for (const auto& row : rows) {
    Words words = row.words;
    words[0] = BinaryPath(words[0]);
    const Ran ran = RunProgram(words);
    EXPECT_EQ(ran.status, 2) << row.meant;
    EXPECT_NE(ran.err.find(std::string("did you mean ") + row.meant), std::string::npos) << ran.err;
  }
}

// A script reads JSON from stdout whatever happens; the status and stderr say what did.
TEST(Json, CommandsThatPrintFactsPrintJsonWithoutAServiceToo) {
  const TempFolder folder;
  const struct {
    Words words;
    int status;  // -1: depends on this machine
  } rows[] = {{{"status"}, 3},
              {{"surfaces"}, 3},
              {{"scene", "edits"}, 3},
              {{"align", "--show"}, 3},
              {{"doctor"}, -1},
              {{"setup"}, 0},
              {{"layer", "status"}, 0},
              {{"scene", "cache"}, 0},
              {{"scene", "explain", "extrusion", "--no-cache"}, 0},
              {{"scene", "explain", "/no/such/file"}, 1},
              {{"replay", "/no/such/file"}, 1},
              {{"twin", "run", "extrusion", "--as-drawn", "--seconds", "0.2"}, -1},
              {{"device", "list"}, -1},
              {{"device", "info", "no such serial"}, 1}};
  for (const auto& row : rows) {
    Words words = row.words;
    words.insert(words.begin(), BinaryPath("omni"));
    words.emplace_back("--json");
    const Ran ran = RunProgram(words, {"OMNI_SOCKET=" + folder.Path("omnid.sock"), "HOME=" + folder.Path("home"),
                                       "XDG_CACHE_HOME=" + folder.Path("cache")});
    if (row.status >= 0) {
      EXPECT_EQ(ran.status, row.status) << row.words.front() << ": " << ran.err;
    }
    const nlohmann::json document = nlohmann::json::parse(ran.out, nullptr, false);
    EXPECT_TRUE(document.is_object() || document.is_array()) << row.words.front() << ": " << ran.out << ran.err;
    if (row.status > 0) {
      EXPECT_TRUE(document.is_object() && document.contains("error")) << ran.out;
    }
  }
}

TEST(Names, ThatAreNotUtf8Work) {
  const TempFolder folder;
  const std::string home = folder.Path("h\xffome"), model = folder.Path("\xfe.glb");
  std::filesystem::create_directories(home);
  std::filesystem::copy_file(OMNI_BINARY_DIR "/share/omni/scenes/extrusion.glb", model);
  const Words environment{"HOME=" + home, "XDG_DATA_HOME=", "XDG_CONFIG_HOME=", "XDG_CACHE_HOME="};
  const auto omni = [&](const Words& more) {
    Words words{BinaryPath("omni")};
    words.insert(words.end(), more.begin(), more.end());
    return RunProgram(words, environment);
  };
  EXPECT_EQ(omni({"layer", "enable"}).status, 0);
  const std::string manifest = home + "/.local/share/openxr/1/api_layers/implicit.d/XrApiLayer_omni.json";
  EXPECT_TRUE(std::filesystem::exists(manifest));
  EXPECT_EQ(omni({"layer", "disable"}).status, 0);
  EXPECT_FALSE(std::filesystem::exists(manifest));
  for (const Words& words :
       {Words{"scene", "explain", model, "--json"}, {"scene", "cache", "--json"}, {"setup", "--json"}}) {
    const Ran ran = omni(words);
    EXPECT_EQ(ran.status, 0) << ran.err;
    EXPECT_FALSE(nlohmann::json::parse(ran.out, nullptr, false).is_discarded()) << ran.out;
  }
}

// With a bad file on its command line omnid ends at once: no socket, no device, no recording.
TEST(ExitStatus, OmnidExitsBeforeStartingWhenAFileIsInvalid) {
  const TempFolder folder;
  std::filesystem::create_directories(folder.Path("run"));
  std::filesystem::permissions(folder.Path("run"), std::filesystem::perms::owner_all);  // as omnid wants it
  const std::string broken = folder.Write("broken", "{ neither JSON nor TOML"), gone = folder.Path("gone/file");
  const std::string socket = folder.Path("run/omnid.sock"), truth = folder.Path("truth.csv");
  const struct {
    const char* option;
    std::string file;
  } rows[] = {{"--twin-script", gone},   {"--twin-script", broken},  {"--calibration", gone},
              {"--calibration", broken}, {"--alignments", broken},   {"--device-file", gone},
              {"--device-file", broken}, {"--record", gone},         {"--record-device", gone},
              {"--twin-record", gone},   {"--record", folder.Path()}};
  for (const auto& row : rows) {
    Words words{BinaryPath("omnid"), "--device", "twin", "--socket", socket, row.option, row.file};
    if (std::string(row.option) != "--twin-record") words.insert(words.end(), {"--twin-record", truth});
    const Ran ran = RunProgram(words, {"XDG_CONFIG_HOME=" + folder.Path("config")}, 10);
    EXPECT_EQ(ran.status, 2) << row.option << " " << row.file << ": " << ran.err;
    EXPECT_EQ(ran.err.find("omnid: " + std::string(row.option) + ": " + row.file), 0U) << ran.err;
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
    EXPECT_FALSE(std::filesystem::exists(socket));
    EXPECT_FALSE(std::filesystem::exists(truth));
  }
}

}  // namespace test_programs_command_line
}  // namespace omni::test
