#include "service/scene/reach.h"

#include <algorithm>
#include <cmath>
#include <glm/geometric.hpp>
#include <iomanip>
#include <limits>
#include <sstream>

#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

constexpr double kFitWidth_m = 0.050;
constexpr double kFitHeight_m = 0.040;
constexpr double kClearance_m = 0.005;  // least distance of what is touched to the hull
constexpr double kFitTopMin_m = 0.015;  // of the model's top over the hull
constexpr double kFitTopMax_m = 0.030;  // force falls off: 0.6 N are left there
constexpr double kFeltStep_m = 5e-5;    // of a surface
constexpr double kReach_m = 0.060;      // over the hull; beyond, the pen is tracked but hardly any force is left

struct Bounds {
  base::Vec3 lower{std::numeric_limits<double>::max(), std::numeric_limits<double>::max(),
                   std::numeric_limits<double>::max()};
  base::Vec3 upper{-std::numeric_limits<double>::max(), -std::numeric_limits<double>::max(),
                   -std::numeric_limits<double>::max()};

  void Add(const base::Vec3& p) {
    lower = {std::min(lower.x, p.x), std::min(lower.y, p.y), std::min(lower.z, p.z)};
    upper = {std::max(upper.x, p.x), std::max(upper.y, p.y), std::max(upper.z, p.z)};
  }
};

// p_B = scale p + offset
void Transform(haptics::SceneInput& input, double scale, const base::Vec3& offset) {
  const auto move = [&](base::Vec3& p) {
    p = {scale * p.x + offset.x, scale * p.y + offset.y, scale * p.z + offset.z};
  };
  for (haptics::InputObject& object : input.objects) {
    std::for_each(object.vertices_base_m.begin(), object.vertices_base_m.end(), move);
  }
  if (input.joystick) move(input.joystick->centre_base_m);
  if (input.vehicle) {
    move(input.vehicle->start_base_m);
    input.vehicle->radius_m *= scale;
    input.vehicle->wheelbase_m *= scale;
    input.vehicle->speed_max_m_s *= scale;
    input.vehicle->acceleration_m_s2 *= scale;
    input.vehicle->grip_g *= scale;  // keeps its cornering the same
    input.vehicle->hit_speed_m_s *= scale;
    input.vehicle->road_wavelength_m *= scale;
    input.vehicle->start_line_m *= scale;
    input.vehicle->line_width_m *= scale;
    for (haptics::Checkpoint& line : input.vehicle->checkpoints) {
      move(line.position_base_m);
      line.width_m *= scale;
    }
  }
}

Placing Fit(haptics::SceneInput& input, double hull_radius_m) {
  Bounds bounds;
  for (const haptics::InputObject& object : input.objects) {
    for (const base::Vec3& p : object.vertices_base_m) bounds.Add(p);
  }
  const double width_m = std::max(bounds.upper.x - bounds.lower.x, bounds.upper.y - bounds.lower.y);
  const double height_m = bounds.upper.z - bounds.lower.z;
  if (!(width_m >= 0 && height_m >= 0)) throw LoadError("", "has nothing to fit: no triangle is left to touch");
  const double scale = std::min(kFitWidth_m / width_m, kFitHeight_m / height_m);  // x / 0 = infinity: no limit
  if (!(scale > 0 && scale <= 1e9)) {
    throw LoadError("", "cannot be scaled into reach: its extent is " + std::to_string(width_m) + " x " +
                            std::to_string(height_m) + " m; check the model's size");
  }
  const double top_m = hull_radius_m + std::clamp(scale * height_m + kClearance_m, kFitTopMin_m, kFitTopMax_m);
  const base::Vec3 offset_m{-scale * (bounds.lower.x + bounds.upper.x) / 2,
                            -scale * (bounds.lower.y + bounds.upper.y) / 2, top_m - scale * bounds.upper.z};
  Transform(input, scale, offset_m);
  return {.fit_scale = scale, .scale = scale, .offset_m = offset_m};
}

}  // namespace

Placing Place(haptics::SceneInput& input, const LoadOptions& options) {
  const base::Vec3& offset = options.offset_base_m;
  if (!(options.scale > 0 && options.scale <= 1e9))
    throw LoadError("", "LoadOptions::scale must be above 0 and at most 1e9");
  if (!(std::abs(offset.x) <= 1e3 && std::abs(offset.y) <= 1e3 && std::abs(offset.z) <= 1e3)) {
    throw LoadError("", "LoadOptions::offset_base_m must be within +-1000 m");
  }
  Placing placing = options.fit ? Fit(input, options.hull_radius_m) : Placing{};
  if (options.scale == 1 && offset == base::Vec3{}) return placing;
  Transform(input, options.scale, offset);
  placing.scale *= options.scale;
  placing.offset_m = options.scale * placing.offset_m + offset;
  return placing;
}

void WarnIfOutOfReach(const haptics::SceneInput& input, const LoadOptions& options, Warnings& warnings) {
  double nearest_m = std::numeric_limits<double>::max();
  for (const haptics::InputObject& object : input.objects) {
    for (const base::Vec3& p : object.vertices_base_m) {
      const double gap_m = Norm(p) - options.hull_radius_m;
      if (object.collidable && p.z > 0) nearest_m = std::min(nearest_m, std::max(gap_m, 0.0));
    }
  }
  if (input.joystick || nearest_m <= kReach_m) return;
  std::ostringstream text;
  text << "nothing to touch within " << kReach_m * 1000 << " mm above the base's hull";
  if (nearest_m < std::numeric_limits<double>::max()) text << " (nearest vertex: " << nearest_m * 1000 << " mm)";
  text << "; load it with fit, or move and scale it over the base (docs/scenes.md)";
  warnings.Add("/scene", text.str());
}

void FloatSteps::Note(const std::string& pointer, const glm::dmat4& place, const DecodedPrimitive& decoded) {
  const glm::dmat3 axes(place);
  const double scale = std::max({glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])});
  if (scale * decoded.float_step <= step_m_) return;
  step_m_ = scale * decoded.float_step;
  reach_m_ = scale * decoded.float_reach;
  pointer_ = pointer;
}

void FloatSteps::WarnIfFelt(double scale, Warnings& warnings) const {
  if (!(scale * step_m_ > kFeltStep_m)) return;
  std::ostringstream text;
  text << std::setprecision(2) << "vertices lie at " << reach_m_ << " m, where a float step is " << 1000 * step_m_
       << " mm: move the model to its origin before exporting";
  warnings.Add(pointer_, text.str());
}

void SuggestUp(const haptics::SceneInput& input, const LoadOptions& options, const Placing& placing,
               Warnings& warnings) {
  if (options.z_up || options.fit || input.joystick) return;
  if (options.memory >= 0 && options.beside == nullptr) return;  // of an application, which places it itself
  // Within a cone of 45 degrees about the vertical, and in reach.
  const auto over_base = [&](const base::Vec3& p) {
    return p.z > 0.7 * Norm(p) && std::abs(Norm(p) - options.hull_radius_m) <= kReach_m;
  };
  std::size_t all = 0, over = 0, over_turned = 0;
  for (const haptics::InputObject& object : input.objects) {
    for (const base::Vec3& p : object.vertices_base_m) {
      const base::Vec3 authored = (1 / placing.scale) * (p - placing.offset_m);
      ++all;
      over += over_base(p) ? 1 : 0;
      over_turned +=
          over_base(placing.scale * base::Vec3{authored.x, authored.z, -authored.y} + placing.offset_m) ? 1 : 0;
    }
  }
  if (over > 0 || 4 * over_turned < all || all == 0) return;
  warnings.Add("/scene",
               "lies beside the base, and would lie over it if the file's z axis were up; if it is, load it with "
               "up = \"z\" (apps.d) or --up z");
}

}  // namespace omni::scene
