#include "tests/bench/harness/chart.h"

#include <cmath>

#include "service/tools/json_text.h"

namespace omni::bench {

std::string RowWord(const nlohmann::json& row, const char* key) {
  const std::string word = row.is_object() ? tools::TextAt(row, (std::string("/") + key).c_str()) : "-";
  return word == "-" ? std::string() : word;
}

double RowValue(const nlohmann::json& row, const char* key) {
  return row.is_object() ? tools::NumberAt(row, (std::string("/") + key).c_str()) : std::nan("");
}

std::string BenchOrigin(const nlohmann::json& document) {
  return "commit " + RowWord(document, "commit") + "; " + RowWord(document, "machine");
}

std::string BenchChart(const nlohmann::json& document, const std::string& title, const PlotAxis& x, const PlotAxis& y,
                       const std::vector<PlotSeries>& series, double width_px) {
  tools::Svg svg(960, 560);
  DrawPlot(svg, {.top_px = 60, .width_px = width_px, .height_px = 430, .title = title, .x = x, .y = y}, series);
  svg.Text(70, 24, "omni-bench " + RowWord(document, "name"), "font-size=\"16\" fill=\"#222\"");
  svg.Text(70, 548, BenchOrigin(document), "font-size=\"10\" fill=\"#777\"");
  return svg.Finish();
}

}  // namespace omni::bench
