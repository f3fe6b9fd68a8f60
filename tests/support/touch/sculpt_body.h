// Closed bodies to sculpt in tests and benchmarks.
#pragma once

#include "service/haptics/geometry/mesh_repair.h"
#include "service/haptics/sculpt/sculpt_editor.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics::sculpt {

inline Mesh Connected(const InputObject& object) {
  RepairCounts counts;
  Mesh mesh = RepairMesh(object, counts);
  for (Vec3& v : mesh.vertices) v = PagedMesh::AsStored(v);  // as files have them
  ConnectAndOrient(mesh);
  return mesh;
}

// A ball with waves of several lengths on it, 12 n^2 triangles.
inline InputObject BumpyBall(int n, double radius_m, double bumps = 0.03) {
  return CubeGrid(n, [=](const Vec3& p) {
    const Vec3 u = Normalized(p);
    const double coarse = std::sin(3 * u.x + 1) * std::sin(4 * u.y) * std::sin(5 * u.z + 2);
    const double fine = std::sin(17 * u.x) * std::sin(19 * u.y + 1) * std::sin(23 * u.z);
    return (radius_m * (1 + bumps * (coarse + 0.2 * fine))) * u;
  });
}

inline InputObject Tetrahedron(double size_m) {
  InputObject object;
  object.name = "tetrahedron";
  object.vertices_base_m = {
      {size_m, size_m, size_m}, {size_m, -size_m, -size_m}, {-size_m, size_m, -size_m}, {-size_m, -size_m, size_m}};
  AddTriangle(object, 0, 1, 2);
  AddTriangle(object, 0, 2, 3);
  AddTriangle(object, 0, 3, 1);
  AddTriangle(object, 1, 3, 2);
  return object;
}

// The editor of a body; null if it cannot be sculpted.
inline std::unique_ptr<SculptEditor> EditorOf(const InputObject& object, const SculptOptions& options = {}) {
  auto editor = SculptEditor::Make(Connected(object), options);
  return editor.ok() ? std::move(*editor) : nullptr;
}

// A point of the surface straight under or over a place.
inline SurfacePoint On(const SculptEditor& editor, const Vec3& place) { return editor.Locate(place, 10); }

}  // namespace omni::haptics::sculpt
