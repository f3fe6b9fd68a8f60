#include "service/monitor/view/scene_view.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <new>
#include <utility>

#include "service/haptics/scene_input.h"
#include "service/scene/drawn_scene.h"

namespace omni::monitor {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

std::array<float, 3> Floats(const base::Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

std::uint8_t Byte(double value) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0))); }

base::Vec3 Placed(const base::Vec3& v, const SceneView& view) {
  return {view.scale * v.x + view.offset_m[0], view.scale * v.y + view.offset_m[1],
          view.scale * v.z + view.offset_m[2]};
}

DrawnShape ShapeOf(const scene::DrawnPart& part, const SceneView& view) {
  DrawnShape shape;
  shape.roughness = static_cast<float>(part.roughness);
  shape.triangles = part.triangles;
  shape.positions.reserve(part.positions_base_m.size());
  shape.normals.reserve(part.normals_base.size());
  shape.colours.reserve(part.colours.size());
  for (const base::Vec3& v : part.positions_base_m) shape.positions.push_back(Floats(Placed(v, view)));
  for (const base::Vec3& n : part.normals_base) shape.normals.push_back(Floats(n));
  base::Vec3 sum;
  for (const base::Vec3& c : part.colours) {
    shape.colours.push_back({Byte(c.x), Byte(c.y), Byte(c.z), 255});
    sum = sum + c;
  }
  if (!part.colours.empty()) shape.colour = Floats((1 / static_cast<double>(part.colours.size())) * sum);
  return shape;
}

// The surface that is touched, where a file does not show which part of it that is.
DrawnShape ShapeOf(const haptics::InputObject& object) {
  DrawnShape shape;
  std::vector<base::Vec3> normals(object.vertices_base_m.size());
  for (const Triangle& t : object.triangles) {
    const base::Vec3 &a = object.vertices_base_m[t[0]], &b = object.vertices_base_m[t[1]],
                     &c = object.vertices_base_m[t[2]];
    const base::Vec3 twice_area = Cross(b - a, c - a);
    for (const std::uint32_t v : t) normals[v] = normals[v] + twice_area;
  }
  for (std::size_t i = 0; i < normals.size(); ++i) {
    const double length = base::Norm(normals[i]);
    shape.positions.push_back(Floats(object.vertices_base_m[i]));
    shape.normals.push_back(Floats(length > 0 ? (1 / length) * normals[i] : base::Vec3{0, 0, 1}));
  }
  shape.triangles = object.triangles;
  return shape;
}

std::uint32_t MainMaterial(const haptics::InputObject& object) {
  std::map<std::uint16_t, std::size_t> uses;
  for (const std::uint16_t material : object.triangle_material) ++uses[material];
  const auto most =
      std::max_element(uses.begin(), uses.end(), [](const auto& a, const auto& b) { return a.second < b.second; });
  return most == uses.end() ? 0 : most->first;
}

std::vector<ViewMaterial> MaterialsOf(const haptics::SceneInput& input) {
  std::vector<ViewMaterial> materials;
  for (const haptics::Material& material : input.materials) {
    materials.push_back({.name = "", .values = base::Clamped(base::ParametersOf(material))});
  }
  for (const haptics::InputObject& object : input.objects) {
    std::vector<bool> used(materials.size());
    for (const std::uint16_t material : object.triangle_material) used[material] = true;
    for (std::size_t i = 0; i < used.size(); ++i) {
      if (used[i]) materials[i].name += (materials[i].name.empty() ? "" : ", ") + object.name;
    }
  }
  return materials;
}

// Object of each name. Empty: the names do not tell the objects apart, or one is of no part.
std::map<std::string, std::int32_t> ObjectsByName(const haptics::SceneInput& input,
                                                  const std::vector<scene::DrawnPart>& parts) {
  std::map<std::string, std::int32_t> objects;
  for (std::size_t i = 0; i < input.objects.size(); ++i) {
    const std::string& name = input.objects[i].name;
    const bool drawn = std::any_of(parts.begin(), parts.end(), [&](const auto& part) { return part.name == name; });
    if (!drawn || !objects.emplace(name, static_cast<std::int32_t>(i)).second) return {};
  }
  return objects;
}

// scale and offset of `fit`, from one vertex before and after.
base::Status FindPlacement(const std::string& path, const scene::LoadOptions& options,
                           const haptics::SceneInput& fitted, double fit_scale, SceneView& view) {
  if (!options.fit || fitted.objects.empty()) return base::Ok{};
  scene::LoadOptions as_authored = options;
  as_authored.fit = false;
  scene::LoadReport report;
  const auto authored = scene::LoadSceneFile(path, as_authored, report);
  if (!authored.ok()) return base::Error{authored.error()};
  const base::Vec3& before = authored->objects.front().vertices_base_m.front();
  const base::Vec3& after = fitted.objects.front().vertices_base_m.front();
  view.scale = fit_scale;
  view.offset_m = {after.x - fit_scale * before.x, after.y - fit_scale * before.y, after.z - fit_scale * before.z};
  return base::Ok{};
}

base::Result<SceneView> Load(const std::string& path, const std::string& name, const scene::LoadOptions& options) {
  SceneView view{.name = name, .path = path};
  scene::LoadReport report;
  const auto input = scene::LoadSceneFile(path, options, report);
  if (!input.ok()) return base::Error{input.error()};
  view.notes = report.warnings;
  if (const auto placed = FindPlacement(path, options, *input, report.fit_scale, view); !placed.ok()) {
    return base::Error{placed.error()};
  }
  view.materials = MaterialsOf(*input);
  const auto drawn = scene::LoadDrawnScene(path);
  if (!drawn.ok()) view.notes.push_back(drawn.error());
  const auto objects = drawn.ok() ? ObjectsByName(*input, drawn->parts) : std::map<std::string, std::int32_t>();
  if (!drawn.ok() || (objects.empty() && !input->objects.empty())) {
    for (std::size_t i = 0; i < input->objects.size(); ++i) {
      const haptics::InputObject& object = input->objects[i];
      view.parts.push_back({object.name, static_cast<std::int32_t>(i), MainMaterial(object), ShapeOf(object)});
    }
    return view;
  }
  for (const scene::DrawnPart& part : drawn->parts) {
    if (!report.vehicle.empty() && part.name == report.vehicle) continue;  // it drives: the page draws it where it is
    const auto found = objects.find(part.name);
    const std::int32_t object = found == objects.end() ? -1 : found->second;
    const std::uint32_t material = object < 0 ? 0 : MainMaterial(input->objects[static_cast<std::size_t>(object)]);
    view.parts.push_back({part.name, object, material, ShapeOf(part, view)});
  }
  return view;
}

}  // namespace

base::Result<SceneView> LoadSceneView(const std::string& path, const std::string& name,
                                      const scene::LoadOptions& options) {
  try {
    return Load(path, name, options);
  } catch (const std::bad_alloc&) {
    return base::Error{name + ": does not fit into memory; simplify the model"};
  }
}

}  // namespace omni::monitor
