#include "service/tools/twin/hand_path.h"

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

namespace omni::tools {
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
