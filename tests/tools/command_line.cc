// The command line: exit statuses, and one line on stderr with the remedy.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <fstream>
#include <initializer_list>
#include <iterator>
#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "tests/support/process/omni_command.h"
#include "tests/support/process/scoped_variable.h"
#include "tests/support/process/temp_folder.h"

namespace omni::tools {
namespace test_tools_command_line {

using test::Outcome;
using test::RunOmni;

void ExpectOneLine(const std::string& text, std::initializer_list<std::string> parts) {
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 1) << text;
  for (const std::string& part : parts) EXPECT_NE(text.find(part), std::string::npos) << part << " not in: " << text;
}

// A closed four-sided pyramid, 20 mm, over the base: 6 triangles, no external file.
std::string Pyramid(const std::string& extras) {
  static const float kVertices[5][3] = {
      {-0.01f, 0.05f, -0.01f}, {0.01f, 0.05f, -0.01f}, {0.01f, 0.05f, 0.01f}, {-0.01f, 0.05f, 0.01f}, {0, 0.06f, 0}};
  static const std::uint16_t kIndices[18] = {0, 4, 1, 1, 4, 2, 2, 4, 3, 3, 4, 0, 0, 1, 2, 0, 2, 3};
  std::string bytes(sizeof(kVertices) + sizeof(kIndices), '\0');
  std::memcpy(bytes.data(), kVertices, sizeof(kVertices));
  std::memcpy(bytes.data() + sizeof(kVertices), kIndices, sizeof(kIndices));
  static const char* const kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string base64;
  for (std::size_t i = 0; i + 2 < bytes.size(); i += 3) {  // 96 bytes: no padding
    const auto at = [&](std::size_t k) { return static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[i + k])); };
    const std::uint32_t group = at(0) << 16 | at(1) << 8 | at(2);
    for (int shift = 18; shift >= 0; shift -= 6) base64 += kDigits[group >> shift & 63];
  }
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
    "nodes": [{"mesh": 0, "name": "pyramid")" +
         extras + R"(}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "buffers": [{"byteLength": 96, "uri": "data:application/octet-stream;base64,)" +
         base64 + R"("}],
    "bufferViews": [{"buffer": 0, "byteOffset": 0, "byteLength": 60}, {"buffer": 0, "byteOffset": 60, "byteLength": 36}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3",
                   "min": [-0.01, 0.05, -0.01], "max": [0.01, 0.06, 0.01]},
                  {"bufferView": 1, "componentType": 5123, "count": 18, "type": "SCALAR"}]})";
}

TEST(ToolsCommandLine, HelpListsSubcommandsAndExitStatuses) {
  const Outcome help = RunOmni({"--help"});
  EXPECT_EQ(help.status, 0);
  for (const char* word : {"status", "watch", "doctor", "scene", "twin", "Exit status"}) {
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  }
  const Outcome below = RunOmni({"scene", "explain", "--help"});
  EXPECT_EQ(below.status, 0);
  EXPECT_NE(below.out.find("--fit"), std::string::npos);
  EXPECT_NE(below.out.find("Exit status"), std::string::npos);
}

TEST(ToolsCommandLine, VersionIsPrinted) {
  const Outcome version = RunOmni({"--version"});
  EXPECT_EQ(version.status, 0);
  EXPECT_EQ(version.out, "omni " OMNI_VERSION "\n");
}

TEST(ToolsCommandLine, WrongArgumentsExitWithStatus2) {
  EXPECT_EQ(RunOmni({}).status, kExitUsage);
  EXPECT_EQ(RunOmni({"dance"}).status, kExitUsage);
  EXPECT_EQ(RunOmni({"status", "--jsn"}).status, kExitUsage);
  EXPECT_EQ(RunOmni({"scene"}).status, kExitUsage);
  EXPECT_EQ(RunOmni({"scene", "explain"}).status, kExitUsage);
  EXPECT_EQ(RunOmni({"twin", "serve"}).status, kExitUsage);
  EXPECT_EQ(RunOmni({"watch", "--seconds", "-1"}).status, kExitUsage);
  EXPECT_NE(RunOmni({"dance"}).err, "");
}

TEST(ToolsCommandLine, SuggestsNearestWordAtEveryLevel) {
  const struct {
    std::vector<std::string> words;
    std::string said;
  } rows[] = {
      {{"statsu"}, "omni: there is no command 'statsu'; did you mean 'status'?\n"},
      {{"scene", "explian", "dragon"}, "omni scene: there is no command 'explian'; did you mean 'explain'?\n"},
      {{"device", "lsit"}, "omni device: there is no command 'lsit'; did you mean 'list'?\n"},
      {{"twin", "rnu"}, "omni twin: there is no command 'rnu'; did you mean 'run'?\n"},
      {{"layer", "enalbe"}, "omni layer: there is no command 'enalbe'; did you mean 'enable'?\n"},
      {{"status", "--jsn"}, "omni status: there is no option '--jsn'; did you mean '--json'?\n"},
      {{"scene", "explain", "dragon", "--tuoch-all"},
       "omni scene explain: there is no option '--tuoch-all'; did you mean '--touch-all'?\n"},
      {{"align", "tuoch"},
       "omni align: method: 'tuoch' is none of touch, sweep, fingertip, nudge; did you mean 'touch'?\n"},
      {{"align", "--hand", "rihgt"},
       "omni align: --hand: 'rihgt' is none of auto, left, right; did you mean 'right'?\n"},
      {{"scene", "save", "x.obj"},
       "omni scene save: file: 'x.obj' does not end in .glb, and binary glTF is all that is written; take x.glb\n"},
      {{"surfaces", "--save", "x.obj"},
       "omni surfaces: --save: 'x.obj' does not end in .glb, and binary glTF is all that is written; take x.glb\n"},
  };
  for (const auto& row : rows) {
    const Outcome wrong = RunOmni(row.words);
    EXPECT_EQ(wrong.status, kExitUsage);
    EXPECT_EQ(wrong.err, row.said);
  }
}

TEST(ToolsCommandLine, FindsScenesByNameInEveryCommand) {
  const test::TempFolder folder;
  folder.Write("data/scenes/pyramid.gltf", Pyramid(R"(, "extras": {"haptic": {"stiffness": 600}})"));
  const test::ScopedVariable data("OMNI_DATA_DIR", folder.Path("data"));
  for (const char* name : {"pyramid", "pyramid.gltf"}) {
    EXPECT_EQ(RunOmni({"scene", "explain", name}).status, kExitOk) << name;
    EXPECT_EQ(RunOmni({"scene", "cost", name}).status, kExitOk) << name;
    EXPECT_EQ(RunOmni({"twin", "path", name, "--fit", "-o", folder.Path("hand.json")}).status, kExitOk) << name;
  }
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{
           {"scene", "explain"}, {"scene", "cost"}, {"twin", "run"}, {"twin", "path", "-o", folder.Path("h.json")}}) {
    std::vector<std::string> all = words;
    all.emplace_back("pyrmaid");
    const Outcome wrong = RunOmni(all);
    EXPECT_EQ(wrong.status, kExitFailed);
    ExpectOneLine(wrong.err, {"'pyrmaid'", folder.Path("data/scenes"), "did you mean 'pyramid'?"});
  }
}

TEST(ToolsCommandLine, TwinRunFailsWhenNothingIsTracked) {
  const test::TempFolder folder;
  const std::string scene = folder.Write("pyramid.gltf", Pyramid(R"(, "extras": {"haptic": {"stiffness": 600}})"));
  const std::string away = folder.Write(
      "away.json",
      R"({"name": "away", "waypoints": [{"s": 0, "tip_m": [0, 0, 0.09], "axis": [0, 0, -1], "present": false}]})");
  const Outcome ran =
      RunOmni({"twin", "run", scene, "--hand", away, "--as-drawn", "--twin", "ideal", "--seconds", "0.1"});
  EXPECT_EQ(ran.status, kExitFailed);
  EXPECT_NE(ran.out.find("tracking error   not measured\n"), std::string::npos) << ran.out;
  EXPECT_EQ(ran.out.find("nan"), std::string::npos) << ran.out;
  ExpectOneLine(ran.err, {"omni twin run:", "not tracked in any tick"});
}

// An uncalibrated base does not find the pen at once; from the first pose on it is where it was expected.
TEST(ToolsTwinRun, ExplainNamesTheHypothesesByStretches) {
  const test::TempFolder folder;
  const std::string scene = folder.Write("pyramid.gltf", Pyramid(R"(, "extras": {"haptic": {"stiffness": 600}})"));
  const std::vector<std::string> run = {"twin", "run", scene, "--as-drawn", "--seconds", "0.5", "--explain"};
  const Outcome ran = RunOmni(run);
  ASSERT_EQ(ran.status, kExitOk) << ran.err;
  const std::size_t table = ran.out.find("explained by     from (s)   to (s)    scans\n");
  ASSERT_NE(table, std::string::npos) << ran.out;
  EXPECT_NE(ran.out.find("  as predicted\n", table), std::string::npos) << ran.out;
  std::vector<std::string> as_json = run;
  as_json.push_back("--json");
  const nlohmann::json json = nlohmann::json::parse(RunOmni(as_json).out);
  int scans = 0;
  for (const auto& stretch : json.at("explained")) {
    EXPECT_LE(stretch.at("begin_ns").get<std::int64_t>(), stretch.at("end_ns").get<std::int64_t>());
    scans += stretch.at("scans").get<int>();
  }
  EXPECT_EQ(scans, json.at("ticks").get<int>());
}

// What a run of one millisecond leaves for `omni report`.
struct RunFiles {
  explicit RunFiles(const test::TempFolder& folder)
      : loop(folder.Write("loop.csv",
                          "t_ns,status,late,force_x_N,force_y_N,force_z_N,magnet_x_m,magnet_y_m,magnet_z_m,tip_x_m,"
                          "tip_y_m,tip_z_m,select,haptic_pulses\n1,2,0,0,0,0,0,0,0,0,0,0,0,0\n")),
        truth(folder.Write("truth.csv", "t_ns,present,magnet_x_m,magnet_y_m,magnet_z_m\n1,1,0,0,0\n")),
        app(folder.Write("app.json", R"({"application": "a", "select_edges": 0, "pose_valid_fraction": 0,
                                         "locate_ns_median": 0})")) {}
  std::string loop, truth, app;
};

TEST(ToolsCommandLine, ReportNamesTheFileThatItWants) {
  const test::TempFolder folder;
  const RunFiles run(folder);
  const std::string gone = folder.Path("gone"), empty = folder.Write("empty", ""),
                    text = folder.Write("text", "a,b\nx\n");
  const auto report = [&](const std::string& a, const std::string& b, const std::string& c) {
    return RunOmni({"report", "--name", "run", "--loop", a, "--truth", b, "--app", c});
  };
  EXPECT_EQ(RunOmni({"report"}).status, kExitUsage);
  ExpectOneLine(RunOmni({"report"}).err, {"--loop: is missing", "omnid --record"});
  ExpectOneLine(RunOmni({"report", "--loop", run.loop}).err, {"--truth: is missing", "omnid --twin-record"});
  ExpectOneLine(RunOmni({"report", "--loop", run.loop, "--truth", run.truth}).err,
                {"--app: is missing", "omni_probe --json"});
  for (const std::string& wrong : {gone, empty, text, folder.Path()}) {
    ExpectOneLine(report(wrong, run.truth, run.app).err, {"--loop: " + wrong, "`omnid --record`"});
    ExpectOneLine(report(run.loop, wrong, run.app).err, {"--truth: " + wrong, "`omnid --twin-record`"});
    ExpectOneLine(report(run.loop, run.truth, wrong).err, {"--app: " + wrong, "`omni_probe --json`"});
    EXPECT_EQ(report(run.loop, run.truth, wrong).status, kExitFailed);
    ExpectOneLine(RunOmni({"report", "--table", wrong}).err, {"--table: " + wrong, "`omni report --summary`"});
  }
  const std::string numbers = folder.Write("numbers.json", R"({"application": 7})");
  ExpectOneLine(report(run.loop, run.truth, numbers).err, {"--app: " + numbers, "/application"});
  const std::string header = folder.Write("header.csv", "t_ns,present,magnet_x_m,magnet_y_m,magnet_z_m\n");
  ExpectOneLine(report(run.loop, header, run.app).err, {"--truth: " + header, "no rows after its header"});
}

TEST(ToolsCommandLine, ReportDoesNotOverwriteForeignSummaryFile) {
  const test::TempFolder folder;
  const RunFiles run(folder);
  const auto add = [&](const std::string& summary) {
    return RunOmni(
        {"report", "--name", "run", "--loop", run.loop, "--truth", run.truth, "--app", run.app, "--summary", summary});
  };
  for (const char* content : {"my notes", "{}", R"({"scenes": [1]})"}) {
    const std::string summary = folder.Write("summary.json", content);
    ExpectOneLine(add(summary).err, {"--summary: " + summary, "`omni report --summary`"});
    std::ifstream file(summary);
    EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), content);
  }
  add(folder.Path("fresh.json"));
  add(folder.Path("fresh.json"));
  const Outcome table = RunOmni({"report", "--table", folder.Path("fresh.json")});
  EXPECT_EQ(table.status, kExitOk) << table.err;
  const std::string head = table.out.substr(0, table.out.find('\n'));
  EXPECT_EQ(head.substr(head.find_last_not_of(' ') - 2, 3), "run") << "one column: " << table.out;
  EXPECT_EQ(head.find("run"), head.rfind("run")) << table.out;
  EXPECT_NE(table.out.find("error of the tip, mean, mm"), std::string::npos) << table.out;
}

TEST(ToolsCommandLine, StatusWithoutServiceSaysHowToStartIt) {
  const test::TempFolder folder;
  const std::string socket = folder.Path("run/omnid.sock");
  const Outcome status = RunOmni({"status", "--socket", socket});
  EXPECT_EQ(status.status, kExitNoService);
  EXPECT_EQ(status.out, "");
  ExpectOneLine(status.err, {"omni status:", socket, "omnid --device twin"});
}

TEST(ToolsCommandLine, WatchWithoutServiceExitsWithRemedy) {
  const test::TempFolder folder;
  const std::string socket = folder.Path("run/omnid.sock");
  const Outcome watch = RunOmni({"watch", "--seconds", "0.2", "--socket", socket});
  EXPECT_EQ(watch.status, kExitNoService);
  ExpectOneLine(watch.err, {"omni watch:", socket, "omnid --device twin"});
  EXPECT_EQ(watch.out.find('\033'), std::string::npos) << "no drawing into a pipe";
}

TEST(ToolsCommandLine, DoctorFailsWithoutServiceAndListsFixes) {
  const test::TempFolder folder;
  const Outcome doctor = RunOmni({"doctor", "--json", "--socket", folder.Path("run/omnid.sock")});
  EXPECT_EQ(doctor.status, kExitFailed);
  const nlohmann::json json = nlohmann::json::parse(doctor.out, nullptr, false);
  ASSERT_TRUE(json.is_object()) << doctor.out;
  EXPECT_EQ(json["ok"], false);
  for (const nlohmann::json& row : json["diagnoses"]) {
    EXPECT_EQ(row["fix"].get<std::string>().empty(), row["verdict"] == "ok") << row.dump();
  }
}

TEST(ToolsCommandLine, DoctorAcceptsApplicationFilesWithInputsOnly) {
  const test::TempFolder folder;
  folder.Write("config/omni/apps.d/keys.toml", "application = \"a\"\n[inputs]\nselect = [\"press\"]\n");
  const test::ScopedVariable config("XDG_CONFIG_HOME", folder.Path("config"));
  const test::ScopedVariable data("OMNI_DATA_DIR", folder.Path("data"));
  const Outcome doctor = RunOmni({"doctor", "--json", "--socket", folder.Path("run/omnid.sock")});
  const nlohmann::json json = nlohmann::json::parse(doctor.out, nullptr, false);
  for (const nlohmann::json& row : json["diagnoses"]) {
    if (row["name"] != "applications") continue;
    EXPECT_EQ(row["verdict"], "ok") << row.dump();
  }
}

TEST(ToolsCommandLine, ExplainShowsLoadedObjectsAndMaterials) {
  const test::TempFolder folder;
  const std::string file = folder.Write(
      "pyramid.gltf", Pyramid(R"(, "extras": {"haptic": {"stiffness": 600, "staticFriction": 0.8, "colour": 1}})"));
  const Outcome text = RunOmni({"scene", "explain", file});
  ASSERT_EQ(text.status, 0) << text.err;
  for (const std::string part : {file.c_str(), "pyramid", "6 triangles", "600 N/m", "static friction 0.8", "warning",
                                 "colour", "built in", "joystick   off"}) {
    EXPECT_NE(text.out.find(part), std::string::npos) << part << " not in:\n" << text.out;
  }
  const Outcome machine = RunOmni({"scene", "explain", "--json", file});
  const nlohmann::json json = nlohmann::json::parse(machine.out, nullptr, false);
  ASSERT_TRUE(json.is_object()) << machine.out;
  EXPECT_EQ(json["triangles"], 6);
  EXPECT_EQ(json["objects"], 1);
  EXPECT_NEAR(json["upper_base_m"][2].get<double>(), 0.06, 1e-6) << "glTF y is up, base z is up";
  EXPECT_FALSE(json["rows"].empty());
  EXPECT_EQ(json["warnings"].size(), 1u) << json["warnings"].dump();
  const bool stiff = std::any_of(json["materials"].begin(), json["materials"].end(),
                                 [](const nlohmann::json& m) { return m["stiffness_N_m"] == 600.0; });
  EXPECT_TRUE(stiff) << json["materials"].dump();
}

TEST(ToolsCommandLine, ExplainShowsThatUntaggedFileCostsNothing) {
  const test::TempFolder folder;
  const std::string file = folder.Write("plain.gltf", Pyramid(""));
  const Outcome text = RunOmni({"scene", "explain", file});
  ASSERT_EQ(text.status, 0) << text.err;
  for (const std::string part :
       {"no haptic tag", "collision  off", "images     0 decoded", "threads    off: none", "0 B of memory"}) {
    EXPECT_NE(text.out.find(part), std::string::npos) << part << " not in:\n" << text.out;
  }
  const nlohmann::json all =
      nlohmann::json::parse(RunOmni({"scene", "explain", "--touch-all", "--json", file}).out, nullptr, false);
  EXPECT_EQ(all["triangles"], 6);
  EXPECT_EQ(all["features"]["collision"]["on"], true);
  EXPECT_EQ(all["features"]["vehicle"]["on"], false);
  const nlohmann::json cost = nlohmann::json::parse(RunOmni({"scene", "cost", file}).out, nullptr, false);
  EXPECT_EQ(cost["skipped"], true);
  EXPECT_EQ(cost["threads"], 0);
  EXPECT_EQ(cost["images_decoded"], 0);
}

TEST(ToolsCommandLine, ExplainWithFitScalesModelIntoReach) {
  const test::TempFolder folder;
  const Outcome fitted = RunOmni({"scene", "explain", "--fit", "--json", folder.Write("p.gltf", Pyramid(""))});
  ASSERT_EQ(fitted.status, 0) << fitted.err;
  const nlohmann::json json = nlohmann::json::parse(fitted.out, nullptr, false);
  EXPECT_GT(json["fit_scale"].get<double>(), 1.0);
  EXPECT_GT(json["upper_base_m"][2].get<double>(), 0.0375 + 0.005);
  EXPECT_LE(json["upper_base_m"][2].get<double>(), 0.0375 + 0.031);
}

TEST(ToolsCommandLine, ExplainTakesTheAxisThatIsUp) {
  const test::TempFolder folder;
  const std::string file = folder.Write("p.gltf", Pyramid(""));
  const auto bounds = [&](const char* up) {
    const Outcome ran = RunOmni({"scene", "explain", "--touch-all", "--no-cache", "--up", up, "--json", file});
    EXPECT_EQ(ran.status, 0) << ran.err;
    const nlohmann::json json = nlohmann::json::parse(ran.out, nullptr, false);
    return std::pair(json["upper_base_m"], json["lower_base_m"]);
  };
  const auto [y_upper, y_lower] = bounds("y");
  const auto [z_upper, z_lower] = bounds("z");
  EXPECT_NEAR(z_upper[1].get<double>(), y_upper[2].get<double>(), 1e-9);
  EXPECT_NEAR(z_upper[2].get<double>(), -y_lower[1].get<double>(), 1e-9);
  EXPECT_NEAR(z_lower[2].get<double>(), -y_upper[1].get<double>(), 1e-9);
  EXPECT_EQ(RunOmni({"scene", "explain", "--up", "x", file}).status, kExitUsage);
}

TEST(ToolsCommandLine, ExplainReadsAnApplicationsFile) {
  const test::TempFolder folder;
  const std::string file = folder.Write("p.gltf", Pyramid(""));
  const std::string app = folder.Write("mine.toml",
                                       "application = \"a\"\nscene = \"b\"\n[[tag]]\nname = \"pyramid\"\n"
                                       "stiffness = 321\n[[tag]]\nname = \"cone\"\n");
  const Outcome ran = RunOmni({"scene", "explain", "--no-cache", "--json", "--app", app, file});
  ASSERT_EQ(ran.status, 0) << ran.err;
  const nlohmann::json json = nlohmann::json::parse(ran.out, nullptr, false);
  EXPECT_EQ(json["objects"], 1);
  EXPECT_EQ(json["materials"][0]["stiffness_N_m"], 321.0);
  ASSERT_EQ(json["warnings"].size(), 1u) << json["warnings"].dump();
  EXPECT_NE(json["warnings"][0].get<std::string>().find("tag \"cone\": is of no node"), std::string::npos);
  const Outcome broken = RunOmni({"scene", "explain", "--app", folder.Write("b.toml", "scene = 3\n"), file});
  EXPECT_EQ(broken.status, kExitFailed);
  ExpectOneLine(broken.err, {"omni scene explain:", "b.toml"});
}

TEST(ToolsCommandLine, ExplainFailsWithOneLine) {
  const test::TempFolder folder;
  const Outcome gone = RunOmni({"scene", "explain", folder.Path("gone.glb")});
  EXPECT_EQ(gone.status, kExitFailed);
  ExpectOneLine(gone.err, {"omni scene explain:", "gone.glb"});
  const Outcome broken = RunOmni({"scene", "explain", folder.Write("b.gltf", "{\"asset\": ")});
  EXPECT_EQ(broken.status, kExitFailed);
  ExpectOneLine(broken.err, {"b.gltf"});
  EXPECT_EQ(broken.out, "");
}

TEST(ToolsCommandLine, MovedCommandsNameTheirReplacement) {
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"bench"}, {"bench", "tick", "--seed", "4"}, {"bench", "--help"}}) {
    const Outcome moved = RunOmni(words);
    EXPECT_EQ(moved.status, kExitUsage);
    ExpectOneLine(moved.err, {"omni bench: ", "--target omni-bench", "build/bench/bin/omni-bench\n"});
  }
  ExpectOneLine(RunOmni({"paper", "forces"}).err, {"omni paper: ", "`omni-bench paper`"});
}

}  // namespace test_tools_command_line
}  // namespace omni::tools
