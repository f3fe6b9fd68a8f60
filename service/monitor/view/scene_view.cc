#include "service/monitor/view/scene_view.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <map>
#include <new>
#include <utility>

#include "service/haptics/scene/scene_input.h"
#include "service/scene/drawn_scene.h"
#include "service/scene/glb_save.h"

namespace omni::monitor {
namespace {

std::array<float, 3> Floats(const base::Vec3& v) {
  return {static_cast<float>(v.x), static_cast<float>(v.y), static_cast<float>(v.z)};
}

std::uint8_t Byte(double value) { return static_cast<std::uint8_t>(std::lround(255 * std::clamp(value, 0.0, 1.0))); }

DrawnShape ShapeOf(const scene::DrawnPart& part, const SceneView& view) {
  DrawnShape shape;
  shape.roughness = static_cast<float>(part.roughness);
  shape.triangles = part.triangles;
  shape.positions.reserve(part.positions_base_m.size());
  shape.normals.reserve(part.normals_base.size());
  shape.colours.reserve(part.colours.size());
  for (const base::Vec3& v : part.positions_base_m) shape.positions.push_back(Floats(view.scale * v + view.offset_m));
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
  for (const base::Vec3& v : object.vertices_base_m) shape.positions.push_back(Floats(v));
  for (const base::Vec3& n : scene::VertexNormals(object)) shape.normals.push_back(Floats(n));
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

// Object of each name. Empty: the names do not distinguish the objects, or one is of no part.
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

base::Result<SceneView> Load(const std::string& path, const std::string& name, scene::LoadOptions options,
                             bool fit_untagged) {
  scene::LoadReport report;
  auto input = scene::LoadSceneFile(path, options, report);
  if (input.ok() && report.skipped && fit_untagged) {
    options.touch_untagged = options.fit = true;
    input = scene::LoadSceneFile(path, options, report);
  }
  if (!input.ok()) return base::Error{input.error()};
  SceneView view{.name = name,
                 .path = path,
                 .touch_untagged = options.touch_untagged,
                 .z_up = options.z_up,
                 .scale = report.placed_scale,
                 .offset_m = report.placed_offset_m};
  view.materials = MaterialsOf(*input);
  const auto drawn = scene::LoadDrawnScene(path, options.z_up);
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
                                      const scene::LoadOptions& options, bool fit_untagged) {
  try {
    return Load(path, name, options, fit_untagged);
  } catch (const std::bad_alloc&) {
    return base::Error{name + ": does not fit into memory; simplify the model"};
  }
}

namespace {

LoadedView LoadRequested(const SceneFileRequest& request) {
  LoadedView loaded{.number = request.number};
  auto view = LoadSceneView(request.path, request.name, request.options, request.fit_untagged);
  if (view.ok()) {
    loaded.view = std::make_shared<const SceneView>(std::move(*view));
  } else {
    loaded.error = view.error();
  }
  return loaded;
}

}  // namespace

std::optional<LoadedView> SceneLoads::Poll() {
  std::optional<LoadedView> finished;
  if (running_.valid()) {
    if (running_.wait_for(std::chrono::seconds(0)) != std::future_status::ready) return std::nullopt;
    finished = running_.get();
  }
  if (wanted_) {
    running_ = std::async(std::launch::async, LoadRequested, *std::exchange(wanted_, std::nullopt));
  }
  return finished;
}

}  // namespace omni::monitor
