#include "service/tools/hand/touch_places.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json.hpp>

namespace omni::tools {
namespace {

constexpr double kGrid_m = 0.002;  // grid spacing
constexpr double kFlat = 0.85;     // cosine of the steepest slope that holds a pressed pen

struct Top {
  double z_m = -std::numeric_limits<double>::infinity();
  double upwards = 0;  // |z| of the surface's unit normal there
  std::uint32_t material = 0;
};

// The surface's highest point over (x, y): a vertical ray through all triangles. Normal of a triangle with the corners
// a, b, c: (b - a) x (c - a), whose z is `area`.
std::optional<Top> TopOf(const haptics::Scene& scene, double x, double y) {
  Top top;
  for (const haptics::Triangle& triangle : scene.triangles()) {
    if ((scene.objects()[triangle.object].flags & haptics::kCollidable) == 0) continue;
    const haptics::Vertex& a = scene.vertices()[triangle.vertex[0]];
    const haptics::Vertex& b = scene.vertices()[triangle.vertex[1]];
    const haptics::Vertex& c = scene.vertices()[triangle.vertex[2]];
    const double area = (b.x - a.x) * (c.y - a.y) - (c.x - a.x) * (b.y - a.y);
    if (!(std::abs(area) > 1e-14)) continue;
    const double wb = ((x - a.x) * (c.y - a.y) - (c.x - a.x) * (y - a.y)) / area;
    const double wc = ((b.x - a.x) * (y - a.y) - (x - a.x) * (b.y - a.y)) / area;
    if (!(wb >= 0 && wc >= 0 && wb + wc <= 1)) continue;
    const double z_m = a.z + wb * (b.z - a.z) + wc * (c.z - a.z);
    if (z_m <= top.z_m) continue;
    const double nx = (b.y - a.y) * (c.z - a.z) - (b.z - a.z) * (c.y - a.y);
    const double ny = (b.z - a.z) * (c.x - a.x) - (b.x - a.x) * (c.z - a.z);
    top = {z_m, std::abs(area) / std::hypot(nx, ny, area), triangle.material};
  }
  if (!std::isfinite(top.z_m)) return std::nullopt;
  return top;
}

// How well a pressed pen stays in place: 2 on a flat place that goes on to all sides, 1 on a flat one, 0 on a slope.
int Hold(const haptics::Scene& scene, double x, double y, const Top& top) {
  if (top.upwards < kFlat) return 0;
  for (const auto& [dx, dy] : {std::pair{kGrid_m, 0.0}, {-kGrid_m, 0.0}, {0.0, kGrid_m}, {0.0, -kGrid_m}}) {
    const std::optional<Top> beside = TopOf(scene, x + dx, y + dy);
    if (!beside || std::abs(beside->z_m - top.z_m) > 0.5 * kGrid_m) return 1;
  }
  return 2;
}

// Of all places within reach those on which the pen holds best.
std::vector<TouchPlace> BestPlaces(const haptics::Scene& scene, const PlaceOptions& options) {
  std::array<std::vector<TouchPlace>, 3> by_hold;
  for (double x = -options.reach_m; x <= options.reach_m; x += kGrid_m) {
    for (double y = -options.reach_m; y <= options.reach_m; y += kGrid_m) {
      if (std::hypot(x, y) > options.reach_m) continue;
      const std::optional<Top> top = TopOf(scene, x, y);
      if (!top) continue;
      const double gap_m = std::hypot(x, y, top->z_m) - options.hull_radius_m;
      if (!(gap_m >= options.gap_min_m && gap_m <= options.gap_max_m)) continue;
      by_hold[static_cast<std::size_t>(Hold(scene, x, y, *top))].push_back({{x, y, top->z_m}, top->material});
    }
  }
  for (std::size_t hold = 2; hold > 0; --hold) {
    if (!by_hold[hold].empty()) return by_hold[hold];
  }
  return by_hold[0];
}

double Distance2(const TouchPlace& one, const TouchPlace& other) {
  const base::Vec3 &a = one.point_base_m, &b = other.point_base_m;
  return (a.x - b.x) * (a.x - b.x) + (a.y - b.y) * (a.y - b.y) + (a.z - b.z) * (a.z - b.z);
}

// Starts nearest to the axis, then repeatedly the place furthest from those chosen.
std::vector<TouchPlace> Broadcast(const std::vector<TouchPlace>& places, int wanted) {
  const auto from_axis_m = [](const TouchPlace& p) { return std::hypot(p.point_base_m.x, p.point_base_m.y); };
  std::vector<TouchPlace> chosen{*std::min_element(
      places.begin(), places.end(), [&](const auto& a, const auto& b) { return from_axis_m(a) < from_axis_m(b); })};
  while (static_cast<int>(chosen.size()) < wanted && chosen.size() < places.size()) {
    const auto nearest = [&](const TouchPlace& p) {
      double best = std::numeric_limits<double>::infinity();
      for (const TouchPlace& c : chosen) best = std::min(best, Distance2(p, c));
      return best;
    };
    chosen.push_back(*std::max_element(places.begin(), places.end(),
                                       [&](const auto& a, const auto& b) { return nearest(a) < nearest(b); }));
  }
  return chosen;
}

}  // namespace

std::vector<TouchPlace> FindTouchPlaces(const haptics::Scene& scene, const PlaceOptions& options) {
  if (scene.empty()) return {};
  PlaceOptions strong = options;
  strong.gap_max_m = std::min(options.gap_max_m, options.gap_strong_m);
  std::vector<TouchPlace> places = BestPlaces(scene, strong);
  if (places.empty()) places = BestPlaces(scene, options);
  return places.empty() ? places : Broadcast(places, options.places);
}

std::string NothingWithinReach(const PlaceOptions& options) {
  return "nothing of the scene lies " + std::to_string(options.gap_min_m * 1e3) + " to " +
         std::to_string(options.gap_max_m * 1e3) +
         " mm above the hull near its top; use --fit, or move the model there";
}

namespace {

constexpr double kAbove_m = 0.020;  // approach from this high above a touch
constexpr double kApproach_s = 1.0;
constexpr double kPress_s = 0.6;
constexpr double kHold_s = 0.5;

}  // namespace

base::Result<sim::HandScript> MakeHandPath(const haptics::Scene& scene, const HandPathOptions& options) {
  const std::vector<TouchPlace> places = FindTouchPlaces(scene, options.places);
  if (places.empty()) return base::Error{NothingWithinReach(options.places)};
  sim::HandScript script;
  script.name = "touch";
  script.repeat = true;
  for (const TouchPlace& place : places) {
    const base::Vec3& p = place.point_base_m;
    const base::Vec3 above{p.x, p.y, p.z + kAbove_m};
    const base::Vec3 below{p.x, p.y, p.z - options.press_m};
    const base::Vec3 aside{p.x * 0.8, p.y * 0.8, p.z - options.press_m};
    script.waypoints.push_back({.duration_s = script.waypoints.empty() ? 0 : kApproach_s, .tip_base_m = above});
    script.waypoints.push_back({.duration_s = kPress_s, .tip_base_m = below});
    script.waypoints.push_back({.duration_s = kHold_s, .tip_base_m = below});
    script.waypoints.push_back({.duration_s = kPress_s, .tip_base_m = aside});
    script.waypoints.push_back({.duration_s = kPress_s, .tip_base_m = above});
  }
  sim::HandWaypoint home = script.waypoints.front();  // so that repeating does not jump
  home.duration_s = kApproach_s;
  script.waypoints.push_back(home);
  return script;
}

std::string WriteHandScript(const sim::HandScript& script) {
  nlohmann::json waypoints = nlohmann::json::array();
  for (const sim::HandWaypoint& point : script.waypoints) {
    const base::Vec3& p = point.tip_base_m;
    const base::Vec3& u = point.axis_base;
    waypoints.push_back({{"s", point.duration_s}, {"tip_m", {p.x, p.y, p.z}}, {"axis", {u.x, u.y, u.z}}});
    if (!point.present) waypoints.back()["present"] = false;
  }
  const nlohmann::json hand{{"stiffness_N_m", script.stiffness_N_m},
                            {"damping_Ns_m", script.damping_Ns_m},
                            {"mass_kg", script.mass_kg},
                            {"tremor_m", script.tremor_m}};
  return nlohmann::json{{"name", script.name}, {"repeat", script.repeat}, {"hand", hand}, {"waypoints", waypoints}}
             .dump(2) +
         "\n";
}

}  // namespace omni::tools
