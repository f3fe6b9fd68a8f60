// The dragon: one closed surface of soft rubber.
#include <cmath>
#include <numbers>

#include "scenes/generator/mesh/mesh.h"
#include "scenes/generator/mesh/polygonise.h"
#include "scenes/generator/models/dragon_shape.h"
#include "scenes/generator/models/scene_models.h"

namespace omni::scenes {
namespace {

constexpr double kCell_mm = 0.55;
constexpr std::size_t kTriangles = 28000;

Mesh DragonMesh() {
  const std::vector<Shape> shapes = DragonShapes();
  Mesh mesh = Polygonise(shapes, {-58, -62, 20}, {54, 62, 96}, kCell_mm);
  KeepLargestComponent(mesh);
  std::vector<double> importance;
  for (const Vec& p : mesh.positions) importance.push_back(DragonImportance(p));
  mesh = Decimate(mesh, importance, kTriangles);
  const std::vector<Vec> normals = VertexNormals(mesh);
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    mesh.colours.push_back(DragonColour(shapes, mesh.positions[i], normals[i]));
  }
  for (Vec& p : mesh.positions) p *= 1e-3;
  Weld(mesh);
  return mesh;
}

// The top of the base's hull, for the eye.
Mesh DomeMesh() {
  constexpr int kAround = 64, kUp = 20;
  Mesh mesh;
  for (int j = 0; j <= kUp; ++j) {
    const double elevation = (0.22 + 0.78 * j / kUp) * std::numbers::pi / 2;
    for (int i = 0; i < kAround; ++i) {
      const double azimuth = 2 * std::numbers::pi * i / kAround;
      const double r = kDome_mm * 1e-3;
      mesh.positions.emplace_back(r * std::cos(elevation) * std::cos(azimuth),
                                  r * std::cos(elevation) * std::sin(azimuth), r * std::sin(elevation));
    }
  }
  for (std::uint32_t j = 0; j < kUp; ++j) {
    for (std::uint32_t i = 0; i < kAround; ++i) {
      const std::uint32_t next = (i + 1) % kAround;
      const std::uint32_t a = j * kAround + i, b = j * kAround + next, c = (j + 1) * kAround + next,
                          d = (j + 1) * kAround + i;
      mesh.triangles.push_back({a, b, c});
      mesh.triangles.push_back({a, c, d});
    }
  }
  Weld(mesh);
  return mesh;
}

}  // namespace

Document DragonScene() {
  Document document;
  document.title = "dragon";
  document.materials = {{"dragon", {1, 1, 1}, 0.6, 0, nullptr, nullptr},
                        {"base", {0.055, 0.062, 0.075}, 0.95, 0, nullptr, nullptr}};
  document.meshes = {{"dragon", DragonMesh(), {0}, {{"MPEG_haptic_material", {{"hapticMaterialIndex", 0}}}}},
                     {"base", DomeMesh(), {1}, nullptr}};
  document.nodes.push_back({"dragon", 0, Vec(0.0), 0, nullptr, {}});
  document.nodes.push_back({"base (seen, not touched)", 1, Vec(0.0), 0, {{"role", "ignore"}}, {}});
  const OrderedJson rubber = {{"stiffness", 500.0},
                              {"damping", 0.4},
                              {"staticFriction", 0.7},
                              {"dynamicFriction", 0.5},
                              {"softness",
                               {{"model", "tet"},
                                {"youngModulus", 5.0e5},
                                {"poissonRatio", 0.45},
                                {"thickness", 0.012},
                                {"maxDepth", 0.008},
                                {"relaxationTime", 0.1}}}};
  document.extensions = {{"MPEG_haptic_material",
                          {{"materials", OrderedJson::array({{{"name", "soft rubber"},
                                                              {"extensions", {{"OMNI_haptic_material", rubber}}}}})}}}};
  document.extensions_used = {"MPEG_haptic_material", "OMNI_haptic_material"};
  return document;
}

}  // namespace omni::scenes
