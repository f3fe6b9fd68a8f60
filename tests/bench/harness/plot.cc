#include "tests/bench/harness/plot.h"

#include <algorithm>
#include <cmath>

namespace omni::bench {
namespace {

constexpr const char* kGrid = "stroke=\"#e4e4e4\"";
constexpr const char* kInk = "fill=\"#444\"";

double Share(const PlotAxis& axis, double value) {
  if (!axis.logarithmic) return (value - axis.low) / (axis.high - axis.low);
  return std::log(value / axis.low) / std::log(axis.high / axis.low);
}

bool Holds(const PlotAxis& axis, double value) {
  const double share = Share(axis, value);
  return share >= -1e-9 && share <= 1 + 1e-9;  // false for NaN
}

std::string Shortest(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.4g", std::abs(value) < 1e-12 ? 0.0 : value);
  return text;
}

// Steps of 1, 2 or 5 times a power of ten, four to eight of them; decades with 2 and 5 when there are few.
std::vector<double> Ticks(const PlotAxis& axis) {
  std::vector<double> ticks;
  if (axis.logarithmic) {
    const bool few = axis.high / axis.low < 200;
    const int first = static_cast<int>(std::floor(std::log10(axis.low)));
    const int last = static_cast<int>(std::floor(std::log10(axis.high * 1.001)));
    for (int power = first; power <= last; ++power) {
      const double decade = std::pow(10, power);
      for (const double factor : {1.0, 2.0, 5.0}) {
        if ((few || factor == 1) && Holds(axis, decade * factor)) ticks.push_back(decade * factor);
      }
    }
    return ticks;
  }
  const double rough = (axis.high - axis.low) / 6;
  const double decade = std::pow(10, std::floor(std::log10(rough)));
  const double step = decade * (rough < 1.5 * decade ? 1 : rough < 3.5 * decade ? 2 : rough < 7.5 * decade ? 5 : 10);
  const double first = std::ceil(axis.low / step - 1e-9);
  const int count = static_cast<int>(std::floor(axis.high / step + 1e-9) - first) + 1;
  for (int i = 0; i < count; ++i) ticks.push_back((first + i) * step);
  return ticks;
}

void DrawAxes(tools::Svg& svg, const PlotBox& box) {
  const double bottom = box.top_px + box.height_px, right = box.left_px + box.width_px;
  for (const double tick : Ticks(box.x)) {
    const double x = box.left_px + box.width_px * Share(box.x, tick);
    svg.Line({x, box.top_px}, {x, bottom}, kGrid);
    svg.Text(x, bottom + 16, Shortest(tick), "text-anchor=\"middle\" font-size=\"11\" fill=\"#444\"");
  }
  const std::vector<double> rows = box.y_ticks ? Ticks(box.y) : std::vector<double>();
  for (const double tick : rows) {
    const double y = bottom - box.height_px * Share(box.y, tick);
    svg.Line({box.left_px, y}, {right, y}, kGrid);
    svg.Text(box.left_px - 6, y + 4, Shortest(tick), "text-anchor=\"end\" font-size=\"11\" fill=\"#444\"");
  }
  svg.Rect(box.left_px, box.top_px, box.width_px, box.height_px, "fill=\"none\" stroke=\"#888\"");
  svg.Text(box.left_px + box.width_px / 2, bottom + 34, box.x.label, "text-anchor=\"middle\" fill=\"#444\"");
  const double middle = box.top_px + box.height_px / 2, across = box.left_px - 46;
  char style[128];
  std::snprintf(style, sizeof(style), "text-anchor=\"middle\" fill=\"#444\" transform=\"rotate(-90 %.1f %.1f)\"",
                across, middle);
  svg.Text(across, middle, box.y.label, style);
  svg.Text(box.left_px, box.top_px - 10, box.title, "font-size=\"14\" fill=\"#222\"");
}

void DrawMark(tools::Svg& svg, tools::SvgPoint at, const PlotSeries& series) {
  const std::string colour = std::string("\"") + series.colour + "\"";
  if (series.mark == PlotSeries::Mark::kDots) {
    svg.Circle(at.x, at.y, 3.5, ("fill=" + colour).c_str());
  } else if (series.mark == PlotSeries::Mark::kRings) {
    svg.Circle(at.x, at.y, 3.5, ("fill=\"#ffffff\" stroke-width=\"1.6\" stroke=" + colour).c_str());
  } else {
    svg.Polygon({{at.x - 5, at.y}, {at.x, at.y - 5}, {at.x + 5, at.y}, {at.x, at.y + 5}}, ("fill=" + colour).c_str());
  }
}

bool IsLine(const PlotSeries& series) {
  return series.mark == PlotSeries::Mark::kLine || series.mark == PlotSeries::Mark::kDashes;
}

std::string LineStyle(const PlotSeries& series) {
  std::string style = std::string("fill=\"none\" stroke-width=\"1.8\" stroke=\"") + series.colour + "\"";
  if (series.mark == PlotSeries::Mark::kDashes) style += " stroke-dasharray=\"6 4\"";
  return style;
}

void DrawOne(tools::Svg& svg, const PlotBox& box, const PlotSeries& series) {
  std::vector<tools::SvgPoint> run;
  const auto finish = [&] {
    if (run.size() > 1) svg.Polyline(run, LineStyle(series).c_str());
    run.clear();
  };
  for (std::size_t i = 0; i < series.points.size(); ++i) {
    const tools::SvgPoint& point = series.points[i];
    if (!(Holds(box.x, point.x) && Holds(box.y, point.y))) {
      finish();
      continue;
    }
    const tools::SvgPoint at = InBox(box, point);
    if (IsLine(series)) {
      run.push_back(at);
    } else {
      DrawMark(svg, at, series);
    }
    if (i < series.labels.size() && !series.labels[i].empty()) {
      const bool left = at.x > box.left_px + 0.75 * box.width_px;
      svg.Text(at.x + (left ? -8 : 8), at.y + 4, series.labels[i],
               left ? "text-anchor=\"end\" font-size=\"10\" fill=\"#444\"" : "font-size=\"10\" fill=\"#444\"");
    }
  }
  finish();
}

void DrawLegend(tools::Svg& svg, const PlotBox& box, const std::vector<PlotSeries>& series) {
  double y = box.top_px + 16;
  const double x = box.left_px + box.width_px + 14;
  for (const PlotSeries& one : series) {
    if (one.name.empty()) continue;
    if (IsLine(one)) {
      svg.Line({x, y - 4}, {x + 18, y - 4}, LineStyle(one).c_str());
    } else {
      DrawMark(svg, {x + 9, y - 4}, one);
    }
    svg.Text(x + 24, y, one.name, kInk);
    y += 18;
  }
}

}  // namespace

tools::SvgPoint InBox(const PlotBox& box, tools::SvgPoint value) {
  return {box.left_px + box.width_px * Share(box.x, value.x), box.top_px + box.height_px * (1 - Share(box.y, value.y))};
}

void DrawPlot(tools::Svg& svg, const PlotBox& box, const std::vector<PlotSeries>& series) {
  DrawAxes(svg, box);
  DrawSeries(svg, box, series);
  if (box.legend) DrawLegend(svg, box, series);
}

void DrawSeries(tools::Svg& svg, const PlotBox& box, const std::vector<PlotSeries>& series) {
  for (const PlotSeries& one : series) DrawOne(svg, box, one);
}

PlotAxis AxisFor(const std::string& label, const std::vector<double>& values, bool logarithmic) {
  PlotAxis axis{label, logarithmic ? 1e300 : 0, logarithmic ? 0 : 1e-12, logarithmic};
  for (const double value : values) {
    if (!(std::isfinite(value) && (!logarithmic || value > 0))) continue;
    axis.low = std::min(axis.low, value);
    axis.high = std::max(axis.high, value);
  }
  if (!logarithmic) {
    const double room = 0.08 * (axis.high - axis.low);
    axis.high += room;
    if (axis.low < 0) axis.low -= room;
    return axis;
  }
  if (!(axis.low <= axis.high)) axis.low = axis.high = 1;
  axis.low = std::pow(10, std::floor(std::log10(axis.low * 0.8)));
  axis.high = std::pow(10, std::ceil(std::log10(axis.high * 1.2)));
  return axis;
}

const char* PlotColour(std::size_t index) {
  constexpr const char* kColours[] = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#56b4e9",
                                      "#e69f00", "#333333", "#882255", "#999933", "#44aa99"};
  return kColours[index % std::size(kColours)];
}

}  // namespace omni::bench
