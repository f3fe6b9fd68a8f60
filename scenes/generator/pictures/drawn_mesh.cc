#include "scenes/generator/pictures/drawn_mesh.h"

#include <cstdio>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <stdexcept>
#include <utility>

#include "service/scene/drawn_scene.h"

namespace omni::scenes {
namespace {

std::vector<Vec> Points(const std::vector<base::Vec3>& from) {
  std::vector<Vec> points;
  points.reserve(from.size());
  for (const base::Vec3& p : from) points.emplace_back(p.x, p.y, p.z);
  return points;
}

double Extent_m(const std::vector<DrawnMesh>& meshes) {
  Vec lower(1e9), upper(-1e9);
  for (const DrawnMesh& drawn : meshes) {
    for (const Vec& p : drawn.mesh.positions) {
      lower = glm::min(lower, p);
      upper = glm::max(upper, p);
    }
  }
  return glm::length(upper - lower);
}

}  // namespace

std::vector<DrawnMesh> ReadMeshes(const std::string& path) {
  const base::Result<scene::DrawnScene> scene = scene::LoadDrawnScene(path);
  if (!scene.ok()) throw std::runtime_error(scene.error());
  for (const std::string& note : scene->notes) std::fprintf(stderr, "scene_render: %s\n", note.c_str());
  std::vector<DrawnMesh> meshes;
  for (const scene::DrawnPart& part : scene->parts) {
    DrawnMesh drawn{.name = part.name, .mesh = {}, .normals = Points(part.normals_base), .roughness = part.roughness};
    drawn.mesh.positions = Points(part.positions_base_m);
    drawn.mesh.colours = Points(part.colours);
    drawn.mesh.triangles = part.triangles;
    meshes.push_back(std::move(drawn));
  }
  if (!(Extent_m(meshes) > 0)) throw std::runtime_error(path + ": all vertices lie in one point; check the export");
  return meshes;
}

}  // namespace omni::scenes
