#include "service/haptics/scene/check_scene.h"

#include <algorithm>
#include <bit>
#include <cstdio>

#include "service/base/material.h"
#include "service/base/vec.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {

using base::Vec3;
namespace {

using base::Error;
using base::Ok;
using base::Status;

constexpr double kLargestNumber = 1e12;  // of a material

bool IsSound(const InputTexture& texture, const SceneInput& input) {
  const bool numbers = std::all_of(texture.to_image.begin(), texture.to_image.end(),
                                   [](double x) { return std::abs(x) <= kMaxTextureTransform; });
  return texture.image < input.images.size() && texture.uv_set < kMaxUvSets && numbers;
}

Status CheckReliefs(const SceneInput& input) {
  if (input.reliefs.size() > kMaxReliefs) {
    return Error{"reliefs: " + std::to_string(input.reliefs.size()) + ", the limit is " + std::to_string(kMaxReliefs)};
  }
  const auto is_side = [](std::uint32_t side) { return std::has_single_bit(side) && side <= kMaxReliefSide; };
  for (const InputRelief& relief : input.reliefs) {
    const bool steps = std::all_of(relief.steps.begin(), relief.steps.end(),
                                   [](float step) { return std::abs(step) <= kMaxReliefStep; });
    if (!(is_side(relief.width) && is_side(relief.height) && relief.image_width > 0 && relief.image_height > 0 &&
          relief.steps.size() <= kMaxReliefBands && steps && IsSound(relief.texture, input) &&
          input.images[relief.texture.image].texels.size() ==
              ReliefTexels(relief.width, relief.height, relief.steps.size()))) {
      return Error{"relief: its size, bands, image, coordinate set or transform is out of range"};
    }
  }
  return Ok{};
}

Status CheckTextures(const SceneInput& input) {
  std::uint64_t texels = 0;
  for (const InputImage& image : input.images) {
    texels += image.texels.size();
    if (image.width == 0 || image.height == 0 ||
        image.texels.size() != std::uint64_t{image.width} * std::uint64_t{image.height}) {
      return Error{"image: the number of texels is not width x height"};
    }
  }
  if (texels > kMaxTexels || input.textures.size() > kMaxTextures) {
    return Error{"textures: " + std::to_string(input.textures.size()) + " with " + std::to_string(texels) +
                 " texels, the limits are " + std::to_string(kMaxTextures) + " and " + std::to_string(kMaxTexels)};
  }
  for (const InputTexture& texture : input.textures) {
    if (!IsSound(texture, input)) return Error{"texture: its image, coordinate set or transform is out of range"};
  }
  if (const Status reliefs = CheckReliefs(input); !reliefs.ok()) return reliefs;
  for (const Material& m : input.materials) {
    if (!(m.relief >= -1 && m.relief < static_cast<std::int64_t>(input.reliefs.size())))
      return Error{"material: uses relief " + std::to_string(m.relief) + " of " + std::to_string(input.reliefs.size())};
    for (const std::int32_t index : {m.stiffness_texture, m.friction_texture, m.vibrotactile_texture}) {
      if (index != -1 && !(index >= 0 && static_cast<std::size_t>(index) < input.textures.size())) {
        return Error{"material: uses texture " + std::to_string(index) + " of " +
                     std::to_string(input.textures.size())};
      }
    }
  }
  return Ok{};
}

Status CheckObject(const InputObject& object, std::size_t index, std::size_t material_count) {
  if (object.triangle_material.size() != object.triangles.size()) {
    return Error{Where(object, index) + ": " + std::to_string(object.triangle_material.size()) + " materials for " +
                 std::to_string(object.triangles.size()) + " triangles; give one per triangle"};
  }
  for (std::size_t t = 0; t < object.triangles.size(); ++t) {
    for (const std::uint32_t v : object.triangles[t]) {
      if (v >= object.vertices_base_m.size()) {
        return Error{Where(object, index) + ": triangle " + std::to_string(t) + " uses vertex " + std::to_string(v) +
                     " of " + std::to_string(object.vertices_base_m.size()) + "; the index buffer is wrong"};
      }
    }
    if (object.triangle_material[t] >= material_count) {
      return Error{Where(object, index) + ": triangle " + std::to_string(t) + " uses material " +
                   std::to_string(object.triangle_material[t]) + " of " + std::to_string(material_count) +
                   "; the material index is out of range"};
    }
  }
  for (const std::vector<CornerUv>& set : object.uv) {
    if (!set.empty() && set.size() != object.triangles.size()) {
      return Error{Where(object, index) + ": texture coordinates for " + std::to_string(set.size()) + " of " +
                   std::to_string(object.triangles.size()) + " triangles; give all or none"};
    }
  }
  for (std::size_t v = 0; v < object.vertices_base_m.size(); ++v) {
    const Vec3& p = object.vertices_base_m[v];
    const double largest = std::max({std::abs(p.x), std::abs(p.y), std::abs(p.z)});
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z) && largest > kMaxCoordinate_m) {
      return Error{Where(object, index) + ": vertex " + std::to_string(v) + " is " + NumberText(largest) +
                   " m from the base, the limit is " + NumberText(kMaxCoordinate_m) + " m; check the unit or scale"};
    }
  }
  return Ok{};
}

}  // namespace

Status CheckJoystick(const JoystickInput& j) {
  if (!IsWithin(j.centre_base_m, kMaxCoordinate_m))
    return Error{"joystick: centre_base_m is not within 10 m of the base"};
  if (!(j.range_m > 0 && j.dead_zone_m >= 0 && j.dead_zone_m < j.range_m)) {
    return Error{"joystick: needs 0 <= dead_zone_m < range_m, got dead_zone_m " + NumberText(j.dead_zone_m) +
                 ", range_m " + NumberText(j.range_m)};
  }
  if (!(j.stiffness_N_m >= 0 && j.damping_Ns_m >= 0))
    return Error{"joystick: stiffness_N_m and damping_Ns_m must be >= 0"};
  if (!(j.detent_force_N >= 0 && j.detent_force_N <= 10 && j.radial_detents >= 0 && j.radial_detents <= 100 &&
        j.angular_detents >= 0 && j.angular_detents <= 100)) {
    return Error{"joystick: detent_force_N must be in [0, 10], radial_detents and angular_detents in [0, 100]"};
  }
  return Ok{};
}

// A line across the road: the start or a checkpoint.
Status CheckLine(const std::string& what, const Checkpoint& line) {
  if (!IsWithin(line.position_base_m, kMaxCoordinate_m)) return Error{what + ": is not within 10 m of the base"};
  if (!(std::abs(line.heading_rad) < 1e3)) return Error{what + ": heading_rad is not an angle"};
  if (!(line.width_m > 0 && line.width_m <= 1e6)) {
    return Error{what + ": its width is " + NumberText(line.width_m) + " m, it must be positive"};
  }
  return Ok{};
}

Status CheckVehicle(const VehicleInput& v) {
  Status start = CheckLine("vehicle: start", {v.start_base_m, v.start_heading_rad, v.line_width_m});
  if (!start.ok()) return start;
  if (!(v.checkpoint_count >= 0 && v.checkpoint_count <= kMaxCheckpoints)) {
    return Error{"vehicle: " + std::to_string(v.checkpoint_count) + " checkpoints, the limit is " +
                 std::to_string(kMaxCheckpoints)};
  }
  for (int k = 0; k < v.checkpoint_count; ++k) {
    Status line = CheckLine("checkpoint " + std::to_string(k), v.checkpoints[static_cast<std::size_t>(k)]);
    if (!line.ok()) return line;
  }
  struct Field {
    const char* name;
    double value;
    double minimum, maximum;  // both allowed
  };
  constexpr double kTiny = 1e-9, kHuge = 1e6;  // positive; scenes may have been scaled to fit
  for (const Field& f :
       {Field{"radius_m", v.radius_m, kTiny, kHuge}, Field{"wheelbase_m", v.wheelbase_m, kTiny, kHuge},
        Field{"speed_max_m_s", v.speed_max_m_s, kTiny, kHuge},
        Field{"acceleration_m_s2", v.acceleration_m_s2, kTiny, kHuge}, Field{"steer_max_rad", v.steer_max_rad, 0, 1.5},
        Field{"grip_g", v.grip_g, kTiny, kHuge},
        Field{"slip_stiffness_front_per_rad", v.slip_stiffness_front_per_rad, 1e-3, 100},
        Field{"slip_stiffness_rear_per_rad", v.slip_stiffness_rear_per_rad, 1e-3, 100},
        Field{"front_share", v.front_share, 0.1, 0.9}, Field{"inertia", v.inertia, 0.1, 10},
        Field{"hit_force_N", v.hit_force_N, 0, 10}, Field{"hit_speed_m_s", v.hit_speed_m_s, kTiny, kHuge},
        Field{"hit_duration_s", v.hit_duration_s, 1e-3, 10}, Field{"hit_to_base", v.hit_to_base, 0, 1},
        Field{"engine_force_N", v.engine_force_N, 0, 0.1}, Field{"engine_frequency_Hz", v.engine_frequency_Hz, 0, 150},
        Field{"road_force_N", v.road_force_N, 0, 0.1}, Field{"road_wavelength_m", v.road_wavelength_m, kTiny, kHuge},
        Field{"start_line_m", v.start_line_m, -kHuge, kHuge}}) {
    if (!(f.value >= f.minimum && f.value <= f.maximum)) {
      return Error{std::string("vehicle: ") + f.name + " is " + NumberText(f.value) + ", it must be in [" +
                   NumberText(f.minimum) + ", " + NumberText(f.maximum) + "]"};
    }
  }
  return Ok{};
}

Status CheckMaterial(const Material& m, std::size_t index) {
  const std::string where = "material " + std::to_string(index) + ": ";
  for (const base::MaterialField& field : base::kMaterialFields) {
    // What moves geometry keeps to its range; a wall may be stiffer than a file can say (benchmarks have such walls).
    const bool strict = field.member.whole || (m.extrude.enabled && base::PartOf(field) == "extrude");
    const double minimum = strict ? field.minimum : 0, maximum = strict ? field.maximum : kLargestNumber;
    const double value = field.Get(m);
    if (!(value >= minimum && value <= maximum)) {
      return Error{where + std::string(field.key) + " is " + NumberText(value) + ", it must be in [" +
                   NumberText(minimum) + ", " + NumberText(maximum) + "]"};
    }
  }
  for (const double x : m.softness.fibre_direction_base) {
    if (!(std::abs(x) <= 1e6))
      return Error{where + "softness.fibreDirection is " + NumberText(x) + ", it must be within +-1e6"};
  }
  return Ok{};
}

base::Status CheckInput(const SceneInput& input) {
  if (input.joystick) {
    Status checked = CheckJoystick(*input.joystick);
    if (!checked.ok()) return checked;
  }
  if (input.vehicle) {
    Status checked = CheckVehicle(*input.vehicle);
    if (!checked.ok()) return checked;
  }
  if (input.materials.empty()) return Error{"scene \"" + input.name + "\": no materials; give at least one"};
  if (input.objects.size() > kMaxObjects) {
    return Error{"scene \"" + input.name + "\": " + std::to_string(input.objects.size()) + " objects, the limit is " +
                 std::to_string(kMaxObjects) + "; join meshes or tag fewer nodes"};
  }
  std::size_t triangles = 0;
  for (const InputObject& object : input.objects) triangles += object.triangles.size();
  if (triangles > kMaxTriangles) {
    return Error{"scene \"" + input.name + "\": " + std::to_string(triangles) + " triangles, the limit is " +
                 std::to_string(kMaxTriangles) + "; simplify the mesh"};
  }
  if (triangles == 0) {
    return Error{"scene \"" + input.name + "\": no triangles; tag at least one node that has a mesh"};
  }
  if (!(input.tip_radius_m >= 0 && input.tip_radius_m <= kMaxTipRadius_m)) {
    return Error{"tip radius: " + NumberText(input.tip_radius_m) + " m, it must be from 0 to " +
                 NumberText(kMaxTipRadius_m)};
  }
  const Status textures = CheckTextures(input);
  if (!textures.ok()) return textures;
  for (std::size_t i = 0; i < input.materials.size(); ++i) {
    Status checked = CheckMaterial(input.materials[i], i);
    if (!checked.ok()) return checked;
  }
  for (std::size_t i = 0; i < input.objects.size(); ++i) {
    Status checked = CheckObject(input.objects[i], i, input.materials.size());
    if (!checked.ok()) return checked;
  }
  return Ok{};
}

std::string NumberText(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::string Where(const InputObject& object, std::size_t index) {
  return "object " + std::to_string(index) + " \"" + object.name + "\"" +
         (object.source.empty() ? "" : " (" + object.source + ")");
}

}  // namespace omni::haptics
