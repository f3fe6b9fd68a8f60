#include "tests/bench/harness/bench_plot.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>
#include <vector>

#include <CLI/CLI.hpp>

#include "service/tools/command_line.h"
#include "service/tools/json_file.h"
#include "service/tools/json_text.h"
#include "service/tools/row_table.h"
#include "service/tools/text_output.h"
#include "tests/bench/harness/chart.h"
#include "tests/bench/harness/commands.h"
#include "tests/bench/harness/plot.h"
#include "tests/bench/harness/plot_layer.h"

namespace omni::bench {
namespace {

using nlohmann::json;

// Of dots with the same label only the rightmost keeps it.
void LabelOnce(PlotSeries& series) {
  std::map<std::string, std::size_t> rightmost;
  for (std::size_t i = 0; i < series.labels.size(); ++i) {
    const auto [kept, first] = rightmost.try_emplace(series.labels[i], i);
    if (first) continue;
    const std::size_t other = kept->second;
    if (series.points[i].x > series.points[other].x) kept->second = i;
    series.labels[series.points[i].x > series.points[other].x ? other : i].clear();
  }
}

// One dot per row: time of a solve against its error. Methods differ by colour, warm and cold by mark.
base::Result<std::string> DrawSolver(const json& document, const std::string& file) {
  std::map<std::string, PlotSeries> by_name;
  std::vector<double> times_us, errors_mm;
  std::vector<std::string> methods;
  for (const json& row : tools::ArrayAt(document, "/rows")) {
    const double us = RowValue(row, "us_median"), mm = RowValue(row, "rms_mm");
    const std::string method = RowWord(row, "method"), start = RowWord(row, "start");
    if (!(us > 0 && mm > 0) || method.empty()) continue;
    if (std::find(methods.begin(), methods.end(), method) == methods.end()) methods.push_back(method);
    const auto colour = static_cast<std::size_t>(std::find(methods.begin(), methods.end(), method) - methods.begin());
    std::string name = method;
    name.append(", ").append(start);
    PlotSeries& series = by_name[std::to_string(colour) + name];
    series.name = std::move(name);
    series.colour = PlotColour(colour);
    series.mark = start == "cold" ? PlotSeries::Mark::kRings : PlotSeries::Mark::kDots;
    series.points.push_back({us, mm});
    // The product's own model goes without saying: most dots are of it, and lie close.
    const std::string model = RowWord(row, "model");
    series.labels.push_back(model == "default" || model == "full" ? "" : model);
    times_us.push_back(us);
    errors_mm.push_back(mm);
  }
  if (times_us.empty())
    return base::Error{file + ": no row has method, us_median and rms_mm; make it with omni-bench solver"};
  std::vector<PlotSeries> series;
  series.reserve(by_name.size());
  for (auto& [key, one] : by_name) {
    LabelOnce(one);
    series.push_back(std::move(one));
  }
  return BenchChart(document, "One solve: run time against error",
                    AxisFor("median time of a solve, us", times_us, true),
                    AxisFor("position error, mm rms", errors_mm, true), series, 640);
}

// Time of a tick over the number of triangles, a line an engine: what the renderer does in full, peers in dashes.
base::Result<std::string> DrawCollision(const json& document, const std::string& file) {
  std::vector<std::string> engines;
  std::map<std::string, PlotSeries> by_engine;
  std::vector<double> counts, times_us;
  for (const json& row : tools::ArrayAt(document, "/rows")) {
    const double n = RowValue(row, "triangles"), us = RowValue(row, "us_median");
    const std::string engine = RowWord(row, "engine");
    // One family of meshes: others are not on the same line.
    if (!(n > 0 && us > 0) || engine.empty() || RowWord(row, "mesh") != "lump") continue;
    if (std::find(engines.begin(), engines.end(), engine) == engines.end()) engines.push_back(engine);
    PlotSeries& series = by_engine[engine];
    series.name = engine;
    series.mark = engine.rfind("omni", 0) == 0 ? PlotSeries::Mark::kLine : PlotSeries::Mark::kDashes;
    series.points.push_back({n, us});
    counts.push_back(n);
    times_us.push_back(us);
  }
  if (times_us.empty())
    return base::Error{file + ": no row of a lump has triangles and us_median; make it with omni-bench collision"};
  std::vector<PlotSeries> series;
  for (std::size_t i = 0; i < engines.size(); ++i) {
    PlotSeries& line = by_engine[engines[i]];
    line.colour = PlotColour(i);
    PlotSeries dots = line;
    dots.name.clear();
    dots.mark = PlotSeries::Mark::kDots;
    series.push_back(line);
    series.push_back(dots);
  }
  return BenchChart(document, "A tick on meshes from 1k to 1M triangles", AxisFor("triangles", counts, true),
                    AxisFor("median time, us", times_us, true), series, 640);
}

std::string Condition(const json& row) {
  std::string text = RowWord(row, "model") + ", " + RowWord(row, "noise");
  const double amplitude_A = RowValue(row, "actuation_A");
  if (amplitude_A > 0) {
    char current[32];
    std::snprintf(current, sizeof(current), ", +-%g A", amplitude_A);
    text += current;
    if (RowWord(row, "currents") == "hidden") text += " hidden";
  }
  const std::string calibrated = RowWord(row, "calibrated");
  if (!calibrated.empty()) text += ", calibrated: " + calibrated;
  if (tools::TrueAt(row, "/moving")) text += ", moving";
  return text;
}

// One line a row: mean, p95 and worst on a logarithmic scale, and the time of a tick where it was measured.
base::Result<std::string> DrawTracking(const json& document, const std::string& file) {
  std::vector<const json*> rows;
  std::vector<double> errors_mm;
  for (const json& row : tools::ArrayAt(document, "/rows")) {
    if (!(RowValue(row, "mean_mm") > 0 && RowValue(row, "p95_mm") > 0)) continue;
    rows.push_back(&row);
    for (const char* key : {"mean_mm", "p95_mm", "max_mm"}) errors_mm.push_back(RowValue(row, key));
  }
  if (rows.empty()) return base::Error{file + ": no row has mean_mm and p95_mm; make it with omni-bench tracking"};
  const double line_px = 24, height_px = line_px * static_cast<double>(rows.size());
  tools::Svg svg(1080, static_cast<int>(height_px) + 170);
  const PlotBox box{.left_px = 420,
                    .top_px = 70,
                    .width_px = 480,
                    .height_px = height_px,
                    .title = "Position error by condition",
                    .x = AxisFor("mm", errors_mm, true),
                    .y = {"", 0, static_cast<double>(rows.size())},
                    .y_ticks = false};
  PlotSeries mean{.name = "mean", .colour = PlotColour(0), .mark = PlotSeries::Mark::kDots};
  PlotSeries p95{.name = "95 %", .colour = PlotColour(1), .mark = PlotSeries::Mark::kRings};
  PlotSeries worst{.name = "worst", .colour = PlotColour(6), .mark = PlotSeries::Mark::kDiamonds};
  svg.Text(20, 28, "omni-bench tracking", "font-size=\"16\" fill=\"#222\"");
  std::vector<PlotSeries> series;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const json& row = *rows[i];
    const double y = static_cast<double>(rows.size() - i) - 0.5;
    series.push_back(
        {.colour = "#bbbbbb",
         .points = {{RowValue(row, "mean_mm"), y}, {RowValue(row, "p95_mm"), y}, {RowValue(row, "max_mm"), y}}});
    mean.points.push_back({RowValue(row, "mean_mm"), y});
    p95.points.push_back({RowValue(row, "p95_mm"), y});
    worst.points.push_back({RowValue(row, "max_mm"), y});
    std::string label = Condition(row);
    if (const double us = RowValue(row, "us_median"); us > 0) {
      char time[32];
      std::snprintf(time, sizeof(time), ", %.2f us", us);
      label += time;
    }
    svg.Text(408, InBox(box, {box.x.low, y}).y + 4, label, "text-anchor=\"end\" fill=\"#444\"");
  }
  series.insert(series.end(), {mean, p95, worst});
  DrawPlot(svg, box, series);
  svg.Text(20, height_px + 150, BenchOrigin(document), "font-size=\"10\" fill=\"#777\"");
  return svg.Finish();
}

// One dot per row that was both timed and judged: time of a tick against error of the force.
base::Result<std::string> DrawDeformable(const json& document, const std::string& file) {
  std::vector<PlotSeries> series;
  std::vector<double> times_us, errors_pct;
  for (const json& row : tools::ArrayAt(document, "/rows")) {
    const double us = RowValue(row, "us_median"), pct = RowValue(row, "error_pct");
    const std::string method = RowWord(row, "method");
    if (!(us > 0 && pct > 0) || method.empty()) continue;
    const auto same = [&](const PlotSeries& one) { return one.name == method; };
    auto found = std::find_if(series.begin(), series.end(), same);
    if (found == series.end()) {
      series.push_back({.name = method, .colour = PlotColour(series.size()), .mark = PlotSeries::Mark::kDots});
      found = series.end() - 1;
    }
    found->points.push_back({us, pct});
    char tets[32];
    std::snprintf(tets, sizeof(tets), "%.0f", RowValue(row, "tets"));
    found->labels.emplace_back(tets);
    times_us.push_back(us);
    errors_pct.push_back(pct);
  }
  if (times_us.empty()) {
    return base::Error{file + ": no row has us_median and error_pct; make it with omni-bench deformable"};
  }
  return BenchChart(document, "One tick with one ball: run time against error of the force, by number of tetrahedra",
                    AxisFor("median time of a tick, us", times_us, true),
                    AxisFor("error against neo-Hookean, %", errors_pct, true), series, 640);
}

// What is offered over the loop's whole lag, by noise, beside the simple rule and the stiffest wall that every hand
// holds.
base::Result<std::string> DrawStability(const json& document, const std::string& file) {
  constexpr double kRest_ms = 0.8;  // half a tick and the coil
  std::map<double, std::array<PlotSeries, 3>> by_noise;
  std::vector<double> lags_ms, stiffness_N_m;
  for (const json& row : tools::ArrayAt(document, "/tables/offered")) {
    const double noise_mm = RowValue(row, "noise_mm"), lag_ms = RowValue(row, "delay_ms") + kRest_ms;
    constexpr const char* kKeys[] = {"offered_N_m", "start_N_m", "fixed_good_N_m"};
    if (!(noise_mm >= 0 && lag_ms > 0)) continue;
    lags_ms.push_back(lag_ms);
    for (std::size_t k = 0; k < 3; ++k) {
      const double value = RowValue(row, kKeys[k]);
      if (!(value > 0)) continue;
      by_noise[noise_mm][k].points.push_back({lag_ms, value});
      stiffness_N_m.push_back(value);
    }
  }
  if (stiffness_N_m.empty()) return base::Error{file + ": has no table of offers; make it with omni-bench stability"};
  std::vector<PlotSeries> series;
  constexpr PlotSeries::Mark kMarks[] = {PlotSeries::Mark::kLine, PlotSeries::Mark::kDashes, PlotSeries::Mark::kRings};
  constexpr const char* kWhat[] = {"offered", "simple rule", "stiffest unpredicted wall held"};
  std::size_t colour = 0;
  for (auto& [noise_mm, three] : by_noise) {
    for (std::size_t k = 0; k < 3; ++k) {
      three[k].colour = PlotColour(colour);
      three[k].mark = kMarks[k];
      char noise[32];
      std::snprintf(noise, sizeof(noise), ", %g mm", noise_mm);
      three[k].name = kWhat[k] + std::string(noise);
      series.push_back(three[k]);
    }
    ++colour;
  }
  return BenchChart(document, "Stiffness that a simulated hand can hold still against, by noise of the position",
                    AxisFor("whole lag: delay, half a tick and coil, ms", lags_ms, true),
                    AxisFor("N/m", stiffness_N_m, true), series, 600);
}

// Empty: drawn.
std::string PlotFile(const std::string& path, const std::string& folder) {
  const base::Result<std::string> text = tools::ReadJsonFile(path, tools::kRowsJson);
  if (!text.ok()) return text.error();
  const auto svg = DrawBench(json::parse(*text), path);
  if (!svg.ok()) return svg.error();
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  const std::string output = folder + "/" + std::filesystem::path(path).stem().string() + ".svg";
  if (std::string problem = tools::WriteText(output, *svg); !problem.empty()) return problem;
  std::cout << output << "\n";
  return {};
}

}  // namespace

base::Result<std::string> DrawBench(const json& document, const std::string& file) {
  if (!document.is_object() || !document.contains("rows")) {
    return base::Error{file +
                       ": no benchmark document ({name, commit, machine, rows}); make it with omni-bench NAME --json"};
  }
  const std::string name = RowWord(document, "name");
  if (name == "solver") return DrawSolver(document, file);
  if (name == "tracking") return DrawTracking(document, file);
  if (name == "stability") return DrawStability(document, file);
  if (name == "collision") return DrawCollision(document, file);
  if (name == "deformable") return DrawDeformable(document, file);
  if (name == "layer") return DrawLayer(document, file);
  if (name == "align") return DrawAlign(document, file);
  return base::Error{file + ": is of omni-bench " + name + "; there is no picture of it"};
}

void AddPlot(CLI::App& app) {
  CLI::App* plot = app.add_subcommand("plot", "pictures (SVG) of run time against error from JSON files of omni-bench");
  auto files = std::make_shared<std::vector<std::string>>();
  auto folder = std::make_shared<std::string>(".");
  plot->add_option("files", *files,
                   "JSON files of omni-bench solver, tracking, stability, collision, deformable, layer and align")
      ->required();
  plot->add_option("-o,--output", *folder, "folder to write NAME.svg into")->capture_default_str();
  plot->callback([files, folder] {
    for (const std::string& file : *files) {
      if (const std::string problem = PlotFile(file, *folder); !problem.empty()) {
        throw CLI::RuntimeError(tools::Fail("omni-bench plot", problem));
      }
    }
    throw CLI::RuntimeError(tools::kExitOk);
  });
}

}  // namespace omni::bench
