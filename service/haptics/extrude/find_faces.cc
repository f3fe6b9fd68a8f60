#include "service/haptics/extrude/extrude.h"

#include <algorithm>

#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

constexpr double kSameFaceCosine = 0.82;
constexpr double kSliverShare = 0.05;

Vec3 DoubleArea(const Mesh& mesh, std::uint32_t t) {
  const auto& v = mesh.triangles[t];
  return Cross(mesh.vertices[v[1]] - mesh.vertices[v[0]], mesh.vertices[v[2]] - mesh.vertices[v[0]]);
}

Vec3 Middle(const Mesh& mesh, std::uint32_t t) {
  const auto& v = mesh.triangles[t];
  return (1.0 / 3) * (mesh.vertices[v[0]] + mesh.vertices[v[1]] + mesh.vertices[v[2]]);
}

Face Grow(const Mesh& mesh, std::uint32_t seed, std::vector<bool>& open, const base::WorkWatch& watch) {
  Face face;
  face.material = mesh.material[seed];
  const Vec3 seed_normal = Normalized(DoubleArea(mesh, seed));
  face.triangles.push_back(seed);
  open[seed] = false;
  for (std::size_t head = 0; head < face.triangles.size(); ++head) {
    watch.Did();
    for (const std::uint32_t other : mesh.neighbours[face.triangles[head]]) {
      if (other == kNoIndex || !open[other] || mesh.material[other] != face.material) continue;
      if (Dot(Normalized(DoubleArea(mesh, other)), seed_normal) < kSameFaceCosine) continue;
      open[other] = false;
      face.triangles.push_back(other);
    }
  }
  return face;
}

void Measure(const Mesh& mesh, Face& face) {
  Vec3 sum;
  for (const std::uint32_t t : face.triangles) {
    const Vec3 a = DoubleArea(mesh, t);
    const double area_m2 = 0.5 * Norm(a);
    sum = sum + a;
    face.area_m2 += area_m2;
    face.centroid_base_m = face.centroid_base_m + area_m2 * Middle(mesh, t);
  }
  face.normal = Normalized(sum);
  if (face.area_m2 > 0) face.centroid_base_m = (1 / face.area_m2) * face.centroid_base_m;
  for (const std::uint32_t t : face.triangles) {
    for (const std::uint32_t v : mesh.triangles[t]) {
      const Vec3 d = mesh.vertices[v] - face.centroid_base_m;
      face.radius_m = std::max(face.radius_m, Norm(d - Dot(d, face.normal) * face.normal));
    }
  }
}

}  // namespace

std::vector<Face> FindFaces(const Mesh& mesh, const std::vector<Material>& materials, const base::WorkWatch& watch) {
  std::vector<std::uint32_t> seeds;
  std::vector<bool> open(mesh.triangles.size(), false);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    watch.Did();
    open[t] = materials[mesh.material[t]].extrude.enabled;
    if (open[t]) seeds.push_back(t);
  }
  std::vector<Face> faces;
  if (seeds.empty()) return faces;
  std::stable_sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) {
    watch.Did();
    return SquaredNorm(DoubleArea(mesh, a)) > SquaredNorm(DoubleArea(mesh, b));
  });
  for (const std::uint32_t seed : seeds) {
    if (!open[seed]) continue;
    faces.push_back(Grow(mesh, seed, open, watch));
    Measure(mesh, faces.back());
  }
  std::stable_sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.area_m2 > b.area_m2; });
  std::erase_if(faces, [largest = faces.front().area_m2](const Face& f) { return f.area_m2 < kSliverShare * largest; });
  return faces;
}

}  // namespace omni::haptics
