#include "tests/bench/harness/plot_layer.h"

#include <algorithm>
#include <map>
#include <set>
#include <vector>

#include "service/tools/json_text.h"
#include "tests/bench/harness/chart.h"

namespace omni::bench {
namespace {

// "free strokes, seed 7" -> "free strokes": what follows the comma says which one.
std::string Kind(const std::string& name) { return name.substr(0, name.find(',')); }

// The place of a name in a list that grows.
std::size_t PlaceIn(std::vector<std::string>& names, const std::string& name) {
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) names.push_back(name);
  return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
}

// Before all other series.
PlotSeries Diagonal(const std::vector<double>& values) {
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  return {.name = "error = predicted",
          .colour = "#999999",
          .points = {{*low, *low}, {*high, *high}},
          .mark = PlotSeries::Mark::kDashes};
}

}  // namespace

// Error of a pose over how far ahead it is asked for, a colour a motion: the layer's line, and a held pose in dashes.
base::Result<std::string> DrawLayer(const nlohmann::json& document, const std::string& file) {
  std::vector<std::string> kinds;
  std::set<std::string> named;                // in the legend
  std::map<std::string, PlotSeries> by_line;  // a line each motion and method
  std::vector<double> horizons_ms, errors_mm;
  for (const nlohmann::json& row : tools::ArrayAt(document, "/tables/motions")) {
    const double ms = RowValue(row, "horizon_ms"), mm = RowValue(row, "error_mm_p95");
    const std::string motion = RowWord(row, "motion"), method = RowWord(row, "method");
    if (!(ms > 0 && mm > 0) || motion.empty() || method.empty()) continue;
    const bool ours = method == "layer";
    PlotSeries& line = by_line[motion + method];
    line.colour = PlotColour(PlaceIn(kinds, Kind(motion)));
    line.mark = ours ? PlotSeries::Mark::kLine : PlotSeries::Mark::kDashes;
    if (ours && line.points.empty() && named.insert(Kind(motion)).second) line.name = Kind(motion) + ", layer";
    line.points.push_back({ms, mm});
    horizons_ms.push_back(ms);
    errors_mm.push_back(mm);
  }
  if (errors_mm.empty()) return base::Error{file + ": has no table of motions; make it with omni-bench layer"};
  std::vector<PlotSeries> series;
  for (auto& [key, line] : by_line) series.push_back(line);
  series.push_back({.name = "the newest pose, held", .colour = "#777777", .mark = PlotSeries::Mark::kDashes});
  return BenchChart(document, "Pose of the pen for a time to come, 95 % of the errors",
                    AxisFor("asked for so long ahead, ms", horizons_ms, false), AxisFor("mm", errors_mm, true), series,
                    640);
}

// The true error over the one that omni align predicts: medians as dots, 95 % as rings.
base::Result<std::string> DrawAlign(const nlohmann::json& document, const std::string& file) {
  std::vector<std::string> methods;
  std::vector<PlotSeries> medians, tails;
  std::vector<double> predicted_mm, errors_mm;
  for (const nlohmann::json& row : tools::ArrayAt(document, "/rows")) {
    const double x = RowValue(row, "predicted_mm"), median = RowValue(row, "error_mm_median");
    const double tail = RowValue(row, "error_mm_p95");
    const std::string method = RowWord(row, "method");
    if (!(x > 0 && median > 0 && tail > 0) || method.empty()) continue;
    const std::size_t at = PlaceIn(methods, Kind(method));
    if (at == medians.size()) {
      const std::string name = Kind(method);
      medians.push_back({.name = name + ", median", .colour = PlotColour(at), .mark = PlotSeries::Mark::kDots});
      tails.push_back({.name = name + ", 95 %", .colour = PlotColour(at), .mark = PlotSeries::Mark::kRings});
    }
    medians[at].points.push_back({x, median});
    tails[at].points.push_back({x, tail});
    predicted_mm.push_back(x);
    errors_mm.insert(errors_mm.end(), {median, tail});
  }
  if (errors_mm.empty()) return base::Error{file + ": no row has predicted_mm; make it with omni-bench align"};
  std::vector<PlotSeries> series{Diagonal(predicted_mm)};
  series.insert(series.end(), medians.begin(), medians.end());
  series.insert(series.end(), tails.begin(), tails.end());
  return BenchChart(document, "Aligned bases: true error over the predicted one, a mark a row",
                    AxisFor("predicted, mm", predicted_mm, true), AxisFor("error, mm", errors_mm, true), series, 640);
}

}  // namespace omni::bench
