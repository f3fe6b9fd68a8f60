#include "service/tools/calibrate/calibrate_twin.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/sim/fields/random.h"
#include "service/sim/fields/vec3.h"

namespace omni::tools {
namespace {

using sim::Random;
using sim::Vec3;

constexpr double kWaveLeg_s = 0.45;  // from turn to turn; far ones reach about 0.4 m/s
constexpr double kWaveFar_m = 0.105;
constexpr double kWaveTilt_rad = 1.0;
constexpr double kTouchTilt_rad = 0.12;
constexpr double kApproach_m = 0.012;                    // above the hull
constexpr double kPress_m = 0.002;                       // into it, against the hand's spring
constexpr double kDimple_N_m = 5000, kDimple_Ns_m = 40;  // what holds the tip is the desk
constexpr double kDimpleTremor_m = 0.05e-3;              // play in the dimple
constexpr double kLift_m = 0.03, kSwing_s = 0.6;
constexpr double kLift_s = 0.12, kMove_s = 0.3, kPress_s = 0.15, kHold_s = 0.3;

Vec3 DrawOutwards(Random& random) {
  const double z = random.Uniform();
  const double angle = random.Uniform(0, 2 * std::numbers::pi);
  const double rho = std::sqrt(1 - z * z);
  return {rho * std::cos(angle), rho * std::sin(angle), z};
}

// Within `tilt_rad` of -outwards.
Vec3 DrawAxis(const Vec3& outwards, double tilt_rad, Random& random) {
  const double c = random.Uniform(std::cos(tilt_rad), 1);
  const double s = std::sqrt(std::max(0.0, 1 - c * c));
  const double angle = random.Uniform(0, 2 * std::numbers::pi);
  const Vec3 across = sim::Perpendicular(outwards);
  return Normalized(-c * outwards + s * std::cos(angle) * across + s * std::sin(angle) * base::Cross(outwards, across));
}

struct Place {
  Vec3 outwards, axis;
};

sim::HandWaypoint At(const base::DeviceGeometry& device, const Place& place, double radius_m, double duration_s) {
  return {.duration_s = duration_s,
          .tip_base_m = radius_m * place.outwards + device.magnet.tip_offset_m * place.axis,
          .axis_base = place.axis};
}

}  // namespace

sim::HandScript MakeCalibratingHand(const base::DeviceGeometry& device, const CalibratingHand& options) {
  Random random(options.seed);
  sim::HandScript script;
  script.name = "calibration";
  script.stiffness_N_m = 400;
  script.damping_Ns_m = 14;
  script.tremor_m = 0.1e-3;
  const sim::HandWaypoint away{.duration_s = 0, .tip_base_m = {0, 0, 0.3}, .axis_base = {0, 0, -1}, .present = false};
  script.waypoints.push_back(away);
  script.waypoints.push_back(away);
  script.waypoints.back().duration_s = options.away_s;

  const double contact_m = device.hull_radius_m + device.magnet.half_height_m;
  const int legs = static_cast<int>(std::ceil(options.wave_s / kWaveLeg_s));
  for (int leg = 0; leg < legs; ++leg) {
    const Vec3 outwards = DrawOutwards(random);
    const Place place{outwards, DrawAxis(outwards, kWaveTilt_rad, random)};
    script.waypoints.push_back(At(device, place, random.Uniform(contact_m, kWaveFar_m), kWaveLeg_s));
  }
  for (int i = 0; i < options.touches; ++i) {
    const Vec3 outwards = DrawOutwards(random);
    const Place place{outwards, DrawAxis(outwards, kTouchTilt_rad, random)};
    script.waypoints.push_back(At(device, place, contact_m + kApproach_m, kMove_s));
    script.waypoints.push_back(At(device, place, contact_m - kPress_m, kPress_s));
    script.waypoints.push_back(At(device, place, contact_m - kPress_m, kHold_s));
    script.waypoints.push_back(At(device, place, contact_m + kApproach_m, kLift_s));
  }
  return script;
}

sim::HandScript MakePivotingHand(const PivotingHand& options) {
  Random random(options.seed);
  const Vec3 down{0, 0, -1};
  const Vec3 above = options.dimple_base_m + kLift_m * Vec3{0, 0, 1};
  sim::HandScript script;
  script.name = "pivot";
  script.stiffness_N_m = kDimple_N_m;
  script.damping_Ns_m = kDimple_Ns_m;
  script.tremor_m = kDimpleTremor_m;
  script.waypoints = {
      {0, above, down}, {1, options.dimple_base_m, down}, {options.rest_s, options.dimple_base_m, down}};
  for (double t_s = 0; t_s < options.swing_s; t_s += kSwing_s) {
    script.waypoints.push_back({kSwing_s, options.dimple_base_m, DrawAxis({0, 0, 1}, options.tilt_rad, random)});
  }
  return script;
}

}  // namespace omni::tools
