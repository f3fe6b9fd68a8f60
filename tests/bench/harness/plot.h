// Charts as SVG: one box with two axes, series as lines or dots, a legend.
#pragma once

#include <string>
#include <vector>

#include "service/tools/svg.h"

namespace omni::bench {

struct PlotAxis {
  std::string label;
  double low = 0, high = 1;
  bool logarithmic = false;  // then 0 < low < high
};

struct PlotSeries {
  std::string name;  // in the legend; empty: not there
  const char* colour = "#1769aa";
  std::vector<tools::SvgPoint> points;  // in the axes' units; what is not finite or outside is left out
  enum class Mark { kLine, kDashes, kDots, kRings, kDiamonds } mark = Mark::kLine;
  std::vector<std::string> labels;  // beside the points; empty: none
};

struct PlotBox {
  double left_px = 70, top_px = 40, width_px = 520, height_px = 320;
  std::string title;
  PlotAxis x, y;
  bool legend = true;
  bool y_ticks = true;
};

void DrawPlot(tools::Svg& svg, const PlotBox& box, const std::vector<PlotSeries>& series);

// More series over what is already in the box.
void DrawSeries(tools::Svg& svg, const PlotBox& box, const std::vector<PlotSeries>& series);

// Where a point lies in the box.
tools::SvgPoint InBox(const PlotBox& box, tools::SvgPoint value);

// The axis that holds all values, with room to spare; a logarithmic one over whole decades.
PlotAxis AxisFor(const std::string& label, const std::vector<double>& values, bool logarithmic);

// Colours that differ for most eyes, by turns [Okabe & Ito].
const char* PlotColour(std::size_t index);

}  // namespace omni::bench
