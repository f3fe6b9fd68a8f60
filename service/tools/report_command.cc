// omni report: judges a run's recordings, appends a row to a summary, draws the picture.
#include <cstdio>
#include <fstream>
#include <iostream>
#include <memory>
#include <string>

#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "service/config/device_file.h"
#include "service/tools/bench.h"
#include "service/tools/command_line.h"
#include "service/tools/commands.h"
#include "service/tools/report.h"
#include "service/tools/run_picture.h"
#include "service/tools/scene_source.h"

namespace omni::tools {
namespace {

using nlohmann::json;

struct ReportArguments {
  std::string name, scene, summary, picture, table;
  RunFiles files;
};

// Adds the row to {"scenes": [...]}; a row of the same scene is replaced.
bool AppendToSummary(const std::string& path, const RunReport& report) {
  json summary = {{"simulation", true}, {"scenes", json::array()}};
  if (std::ifstream file(path); file) {
    json old = json::parse(file, nullptr, false);
    if (old.is_object() && old.contains("scenes") && old["scenes"].is_array()) summary = std::move(old);
  }
  json kept = json::array();
  for (const json& row : summary["scenes"]) {
    if (row.value("scene", "") != report.scene) kept.push_back(row);
  }
  kept.push_back(ToJson(report));
  summary["scenes"] = kept;
  std::ofstream file(path);
  file << summary.dump(2) << "\n";
  file.close();
  return static_cast<bool>(file);
}

bool WritePicture(const ReportArguments& arguments, const RunReport& report, const RunData& data) {
  haptics::Scene scene;
  if (!arguments.scene.empty()) {
    auto loaded =
        LoadScene(arguments.scene, {.touch_untagged = report.scene == "custom", .fit = report.scene == "custom"});
    if (loaded.ok()) scene = std::move(loaded->scene);
  }
  std::ofstream file(arguments.picture);
  file << DrawRun(report, data, scene, config::DefaultDevice().hull_radius_m);
  file.close();
  return static_cast<bool>(file);
}

int ShowTable(const std::string& path) {
  std::ifstream file(path);
  const json summary = json::parse(file, nullptr, false);
  if (!summary.is_object() || !summary.contains("scenes")) return Fail("omni report", path + ": not a summary");
  BenchRows rows;
  for (const json& row : summary["scenes"]) {
    nlohmann::ordered_json line;
    for (const char* key :
         {"scene", "profile", "ticks", "late_ticks", "tracking_mean_mm", "tracking_p95_mm", "contact_ticks",
          "peak_force_N", "select_edges", "haptic_pulses", "pose_valid_fraction", "locate_ns_median"}) {
      line[key] = row.value(key, json());
    }
    rows.push_back(line);
  }
  std::cout << BenchTable(rows);
  return 0;
}

int MakeRunReport(const ReportArguments& arguments) {
  RunData data;
  auto report = MakeReport(arguments.name, arguments.files, data);
  if (!report.ok()) return Fail("omni report", report.error());
  if (!arguments.summary.empty() && !AppendToSummary(arguments.summary, *report)) {
    return Fail("omni report", arguments.summary + ": cannot be written");
  }
  if (!arguments.picture.empty() && !WritePicture(arguments, *report, data)) {
    return Fail("omni report", arguments.picture + ": cannot be written");
  }
  const std::vector<std::string> shortcomings = Shortcomings(*report);
  for (const std::string& line : shortcomings) std::cerr << line << "\n";
  return shortcomings.empty() ? 0 : 1;
}

}  // namespace

void AddReport(CLI::App& app) {
  CLI::App* report = app.add_subcommand("report", "judge a run's recordings against the twin's truth");
  auto arguments = std::make_shared<ReportArguments>();
  report->add_option("--name", arguments->name, "name of the run");
  report->add_option("--scene", arguments->scene, "scene file, drawn in the picture");
  report->add_option("--loop", arguments->files.loop, "omnid --record");
  report->add_option("--truth", arguments->files.truth, "omnid --twin-record");
  report->add_option("--app", arguments->files.app, "what the app saw (omni_probe --json)");
  report->add_option("--summary", arguments->summary, "JSON file to add a row to");
  report->add_option("--picture", arguments->picture, "SVG file to write");
  report->add_option("--table", arguments->table, "print a summary file as a table, nothing else");
  report->callback([arguments] {
    throw CLI::RuntimeError(arguments->table.empty() ? MakeRunReport(*arguments) : ShowTable(arguments->table));
  });
}

}  // namespace omni::tools
