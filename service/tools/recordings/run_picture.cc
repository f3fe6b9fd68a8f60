#include "service/tools/recordings/report.h"

#include <algorithm>
#include <cmath>
#include <functional>

#include "service/tools/common/output.h"
#include "service/tools/recordings/svg.h"

namespace omni::tools {
namespace {

constexpr double kScale_px_m = 3600;  // views: 100 mm = 360 px
constexpr double kView_m = 0.11;      // width and height of a view
constexpr std::size_t kPathStride = 8;

double ForceAt(const CsvTable& loop, std::size_t i) {
  return std::hypot(loop["force_x_N"][i], loop["force_y_N"][i], loop["force_z_N"][i]);
}

// A view along one axis, at a place of the picture.
struct View {
  double left_px, top_px;
  SceneView seen;

  SvgPoint operator()(const base::Vec3& p) const {
    const base::Vec3 from = p - seen.centre_m;
    return {left_px + (kView_m / 2 + base::Dot(from, seen.right)) * kScale_px_m,
            top_px + (kView_m / 2 - base::Dot(from, seen.up)) * kScale_px_m};
  }
};

void DrawScene(Svg& svg, const View& view, const haptics::Scene& scene) {
  if (scene.empty()) return;
  for (const DrawnTriangle& triangle : SeenTriangles(scene, view.seen, static_cast<int>(kView_m * kScale_px_m))) {
    std::vector<SvgPoint> corners;
    for (const base::Vec3& corner : triangle.corners_m) corners.push_back(view(corner));
    const auto shade = [&](double full) { return static_cast<int>(std::lround(full * triangle.brightness)); };
    const std::string colour = Format("#%02x%02x%02x", shade(214), shade(224), shade(235));
    // The line closes the gaps between neighbours.
    svg.Polygon(corners, ("fill=\"" + colour + "\" stroke=\"" + colour + "\" stroke-width=\"0.4\"").c_str());
  }
}

void DrawPath(Svg& svg, const View& view, const CsvTable& loop) {
  std::vector<SvgPoint> path;
  std::vector<SvgPoint> contacts;
  for (std::size_t i = 0; i < loop.rows(); i += kPathStride) {
    if (loop["status"][i] < 1.5) continue;
    const SvgPoint p = view({loop["tip_x_m"][i], loop["tip_y_m"][i], loop["tip_z_m"][i]});
    path.push_back(p);
    if (ForceAt(loop, i) > kContact_N) contacts.push_back(p);
  }
  svg.Polyline(path, "fill=\"none\" stroke=\"#1769aa\" stroke-width=\"1.2\"");
  for (const SvgPoint& p : contacts) svg.Circle(p.x, p.y, 1.8, "fill=\"#d1342f\" fill-opacity=\"0.5\"");
}

void DrawView(Svg& svg, const View& view, const std::string& title, const RunData& data, const haptics::Scene& scene,
              double hull_radius_m) {
  const double size_px = kView_m * kScale_px_m;
  svg.Raw("<clipPath id=\"c" + std::to_string(static_cast<int>(view.left_px)) + "\"><rect x=\"" +
          std::to_string(view.left_px) + "\" y=\"" + std::to_string(view.top_px) + "\" width=\"" +
          std::to_string(size_px) + "\" height=\"" + std::to_string(size_px) + "\"/></clipPath>");
  svg.Raw("<g clip-path=\"url(#c" + std::to_string(static_cast<int>(view.left_px)) + ")\">");
  const SvgPoint centre = view(base::Vec3{});
  svg.Circle(centre.x, centre.y, hull_radius_m * kScale_px_m, "fill=\"#f3efe6\" stroke=\"#a08b5b\"");
  DrawScene(svg, view, scene);
  DrawPath(svg, view, data.loop);
  svg.Raw("</g>");
  svg.Rect(view.left_px, view.top_px, size_px, size_px, "fill=\"none\" stroke=\"#888\"");
  svg.Text(view.left_px + 6, view.top_px + 16, title, "fill=\"#444\"");
  svg.Line({view.left_px + size_px - 80, view.top_px + size_px - 12},
           {view.left_px + size_px - 80 + 0.02 * kScale_px_m, view.top_px + size_px - 12},
           "stroke=\"#444\" stroke-width=\"2\"");
  svg.Text(view.left_px + size_px - 66, view.top_px + size_px - 16, "20 mm", "fill=\"#444\" font-size=\"10\"");
}

// A strip over time: values by name and colour.
struct Trace {
  std::string name;
  const char* colour;
  std::function<double(std::size_t)> value;
};

void DrawStrip(Svg& svg, double top_px, double height_px, double low, double high, const std::string& unit,
               const RunData& data, const std::vector<Trace>& traces) {
  constexpr double kLeft_px = 60;
  constexpr double kWidth_px = 760;
  const CsvTable& loop = data.loop;
  if (loop.rows() < 2) return;
  const double t0_ns = loop["t_ns"].front();
  const double span_s = std::max(1e-3, (loop["t_ns"].back() - t0_ns) * 1e-9);
  svg.Rect(kLeft_px, top_px, kWidth_px, height_px, "fill=\"none\" stroke=\"#888\"");
  for (const double level : {low, high}) {
    svg.Text(kLeft_px - 6, top_px + height_px * (1 - (level - low) / (high - low)) + 4,
             std::to_string(level).substr(0, level < 0 ? 4 : 3), "text-anchor=\"end\" fill=\"#444\"");
  }
  svg.Text(14, top_px + height_px / 2, unit, "fill=\"#444\"");
  const std::size_t stride = 1 + loop.rows() / 3000;
  double label_px = kLeft_px + 8;
  for (const Trace& trace : traces) {
    std::vector<SvgPoint> points;
    for (std::size_t i = 0; i < loop.rows(); i += stride) {
      const double t_s = (loop["t_ns"][i] - t0_ns) * 1e-9;
      const double share = std::clamp((trace.value(i) - low) / (high - low), 0.0, 1.0);
      points.push_back({kLeft_px + kWidth_px * t_s / span_s, top_px + height_px * (1 - share)});
    }
    const std::string colour = trace.colour;
    svg.Polyline(points, ("fill=\"none\" stroke=\"" + colour + "\"").c_str());
    svg.Text(label_px, top_px + 14, trace.name, ("font-size=\"11\" fill=\"" + colour + "\"").c_str());
    label_px += 14 + 7.0 * static_cast<double>(trace.name.size());
  }
  svg.Text(kLeft_px + kWidth_px, top_px + height_px + 14, std::to_string(static_cast<int>(std::lround(span_s))) + " s",
           "text-anchor=\"end\" fill=\"#444\"");
}

}  // namespace

std::string DrawRun(const RunReport& report, const RunData& data, const haptics::Scene& scene, double hull_radius_m) {
  Svg svg(860, 800);
  char title[256];
  std::snprintf(title, sizeof(title), "%s - %s (simulated by the digital twin)", report.scene.c_str(),
                report.profile.empty() ? "no profile" : report.profile.c_str());
  svg.Text(20, 24, title, "font-size=\"16\" fill=\"#222\"");
  std::snprintf(title, sizeof(title),
                "tracking error mean %.2f mm, p95 %.2f mm; %llu contact ticks, peak %.2f N; %llu select presses",
                report.tracking.mean_mm, report.tracking.p95_mm, static_cast<unsigned long long>(report.contact_ticks),
                report.peak_force_N, static_cast<unsigned long long>(report.select_edges));
  svg.Text(20, 44, title, "fill=\"#444\"");
  const View side{20, 60, {{0, 0, 0.045}, {1, 0, 0}, {0, 0, 1}, kView_m / 2}};
  const View top{440, 60, {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, kView_m / 2}};
  DrawView(svg, side, "side view (x right, z up); red: force on the tip", data, scene, hull_radius_m);
  DrawView(svg, top, "top view (x right, y up)", data, scene, hull_radius_m);

  const CsvTable& loop = data.loop;
  const auto column = [&](const char* name) { return [&loop, name](std::size_t i) { return loop[name][i]; }; };
  DrawStrip(svg, 490, 110, 0, 2, "N", data, {{"force", "#d1342f", [&](std::size_t i) { return ForceAt(loop, i); }}});
  DrawStrip(svg, 630, 50, 0, 1.2, "", data,
            {{"select", "#1769aa", column("select")}, {"gate", "#2e7d32", column("gate")}});
  DrawStrip(svg, 710, 60, -1, 1, "", data,
            {{"thumbstick x", "#1769aa", column("thumb_x")}, {"thumbstick y", "#d1342f", column("thumb_y")}});
  return svg.Finish();
}

}  // namespace omni::tools
