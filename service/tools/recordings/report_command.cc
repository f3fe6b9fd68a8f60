// omni report: evaluates a run's recordings, appends a row to a summary, draws the picture.
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <iostream>
#include <memory>
#include <string>

#include <nlohmann/json.hpp>

#include "service/config/files/device_file.h"
#include "service/console/wrap.h"
#include "service/haptics/scene/scene.h"
#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"
#include "service/tools/recordings/report.h"
#include "service/tools/scene/scene.h"

namespace omni::tools {
namespace {

using nlohmann::json;

struct ReportArguments {
  std::string name, scene, summary, picture, table;
  RunFiles files;
};

// {"scenes": [rows]}, as AddToSummary writes it.
base::Result<json> ReadSummary(const char* option, const std::string& path) {
  const auto wrong = [&](const std::string& why) {
    return base::Error{std::string(option) + ": " + why +
                       "; expected a summary: the JSON file of `omni report --summary`"};
  };
  const base::Result<std::string> text = ReadJsonFile(path, kRowsJson);
  if (!text.ok()) return wrong(text.error());
  json summary = json::parse(*text);
  if (!summary.is_object() || !summary.contains("scenes")) return wrong(path + ": has no /scenes");
  const json& rows = summary["scenes"];
  const bool sound = rows.is_array() && std::all_of(rows.begin(), rows.end(), [](const json& row) {
                       return row.is_object() && row.contains("scene") && row["scene"].is_string();
                     });
  if (!sound) return wrong(path + ": /scenes is not a list of rows that each name a scene");
  return summary;
}

// A row of the same scene is replaced. A missing or empty summary starts with this row.
base::Status AddToSummary(const std::string& path, const RunReport& report) {
  json summary = {{"simulation", true}, {"scenes", json::array()}};
  std::error_code error;
  if (const auto bytes = std::filesystem::file_size(path, error); !error && bytes > 0) {
    base::Result<json> old = ReadSummary("--summary", path);
    if (!old.ok()) return base::Error{old.error()};
    summary = std::move(*old);
  }
  json kept = json::array();
  for (const json& row : summary["scenes"]) {
    if (row["scene"] != report.scene) kept.push_back(row);
  }
  kept.push_back(ToJson(report));
  summary["scenes"] = kept;
  const std::string problem = WriteText(path, summary.dump(2) + "\n");
  if (!problem.empty()) return base::Error{"--summary: " + problem};
  return base::Ok{};
}

// Empty without --scene: only the run is drawn.
base::Result<haptics::Scene> SceneOfRun(const std::string& name, bool custom) {
  if (name.empty()) return haptics::Scene();
  const base::Result<std::string> path = FindScene(name);
  if (!path.ok()) return base::Error{"--scene: " + path.error()};
  base::Result<LoadedScene> loaded = LoadScene(*path, {.touch_untagged = custom, .fit = custom});
  if (!loaded.ok()) return base::Error{"--scene: " + loaded.error()};
  return std::move(loaded->scene);
}

base::Status WritePicture(const ReportArguments& arguments, const RunReport& report, const RunData& data) {
  const auto scene = SceneOfRun(arguments.scene, report.scene == "custom");
  if (!scene.ok()) return base::Error{scene.error()};
  const std::string svg = DrawRun(report, data, *scene, config::DefaultDevice().hull_radius_m);
  const std::string problem = WriteText(arguments.picture, svg);
  if (!problem.empty()) return base::Error{"--picture: " + problem};
  return base::Ok{};
}

struct Figure {
  const char* heading;
  const char* key;  // of a row of the summary
  double scale;
  int digits;
};
constexpr Figure kFigures[] = {
    {"ticks of a millisecond", "ticks", 1, 0},
    {"of them late", "late_ticks", 1, 0},
    {"pen tracked, %", "tracked_fraction", 100, 1},
    {"pen tracked coarsely, %", "coarse_fraction", 100, 1},
    {"error of the tip, mean, mm", "tracking_mean_mm", 1, 2},
    {"error of the tip, p95, mm", "tracking_p95_mm", 1, 2},
    {"in contact, s", "contact_ticks", 1e-3, 1},
    {"largest force, N", "peak_force_N", 1, 2},
    {"force reached, N", "force_reached_N", 1, 2},
    {"gap in use, mean, mm", "gap_mean_mm", 1, 1},
    {"gap in use, p95, mm", "gap_p95_mm", 1, 1},
    {"changes of select in the app", "select_edges", 1, 0},
    {"pulses from the app", "haptic_pulses", 1, 0},
    {"pose valid in the app, %", "pose_valid_fraction", 100, 1},
    {"xrLocateSpace, median, us", "locate_ns_median", 1e-3, 1},
};

std::string FigureText(const json& row, const Figure& figure) {
  const json value = row.value(figure.key, json());
  if (!value.is_number()) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), "%.*f", figure.digits, figure.scale * value.get<double>());
  return text;
}

// A column for each scene.
int ShowTable(const std::string& path) {
  const base::Result<json> summary = ReadSummary("--table", path);
  if (!summary.ok()) return Fail("omni report", summary.error());
  Rows lines;
  const auto add = [&](const std::string& heading, const auto& text) {
    nlohmann::ordered_json line = {{"simulated", heading}};
    for (const json& row : (*summary)["scenes"]) line[row["scene"].get<std::string>()] = text(row);
    lines.push_back(line);
  };
  add("interaction profile", [](const json& row) {
    const std::string profile = row.contains("profile") && row["profile"].is_string() ? row["profile"] : "-";
    return profile.substr(profile.rfind('/') + 1);
  });
  for (const Figure& figure : kFigures) add(figure.heading, [&](const json& row) { return FigureText(row, figure); });
  std::cout << RowTable(lines);
  return kExitOk;
}

int MakeRunReport(const ReportArguments& arguments) {
  RunData data;
  auto report = MakeReport(arguments.name, arguments.files, data);
  if (!report.ok()) return Fail("omni report", report.error());
  if (!arguments.summary.empty()) {
    const base::Status added = AddToSummary(arguments.summary, *report);
    if (!added.ok()) return Fail("omni report", added.error());
  }
  if (!arguments.picture.empty()) {
    const base::Status drawn = WritePicture(arguments, *report, data);
    if (!drawn.ok()) return Fail("omni report", drawn.error());
  }
  const std::vector<std::string> shortcomings = Shortcomings(*report);
  for (const std::string& line : shortcomings) std::cerr << console::ForPeople(line + "\n", STDERR_FILENO);
  return shortcomings.empty() ? kExitOk : kExitFailed;
}

int Report(const ReportArguments& arguments) {
  if (!arguments.table.empty()) return ShowTable(arguments.table);
  for (const RunFileEntry& entry : kRunFiles) {
    if (!(arguments.files.*entry.path).empty()) continue;
    return FailUsage("omni report", std::string(entry.option) + ": is missing; give " + entry.what);
  }
  return MakeRunReport(arguments);
}

}  // namespace

void AddReport(Command& app) {
  Command report = app.AddCommand("report", "compare a run's recordings with the twin's truth");
  auto arguments = std::make_shared<ReportArguments>();
  report.Add("--name", arguments->name, "name of the run");
  report.Add("--scene", arguments->scene, "drawn in the picture: a scene file, or the name of a shipped one");
  for (const RunFileEntry& entry : kRunFiles) report.Add(entry.option, arguments->files.*entry.path, entry.what);
  report.Add("--summary", arguments->summary, "JSON file to add a row to");
  report.Add("--picture", arguments->picture, "picture to write").WritesOnly(".svg", "SVG");
  report.Add("--table", arguments->table, "print a summary file as a table, nothing else");
  report.SetAction(arguments, Report);
}

}  // namespace omni::tools
