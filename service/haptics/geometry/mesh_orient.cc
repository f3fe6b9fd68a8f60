#include "service/haptics/geometry/mesh_steps.h"

#include <algorithm>
#include <numeric>
#include <vector>

#include "service/haptics/geometry/winding_number.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

constexpr std::size_t kSamples = 16;                     // of a component, equal parts of its area
constexpr std::size_t kMaxAsked = 4096;                  // largest components by area; smaller ones stay as they are
constexpr std::size_t kMaxWindingTriangles = 2'000'000;  // larger meshes of many parts: by the sign of volumes alone
constexpr int kMaxRounds = 8;
constexpr double kSure = 0.02;  // a sheet's winding number on itself is 0, within the tree's error

struct Part {
  double volume_m3 = 0;  // signed
  double area_m2 = 0;
  bool closed = true;
  Vec3 lower{1e30, 1e30, 1e30}, upper{-1e30, -1e30, -1e30};
  std::vector<std::uint32_t> samples;  // triangles
};

bool PartContains(const Part& outer, const Part& inner) {
  return outer.lower.x < inner.lower.x && outer.lower.y < inner.lower.y && outer.lower.z < inner.lower.z &&
         outer.upper.x > inner.upper.x && outer.upper.y > inner.upper.y && outer.upper.z > inner.upper.z;
}

double TriangleArea(const Mesh& mesh, std::uint32_t t) {
  const auto& [a, b, c] = mesh.triangles[t];
  return 0.5 * Norm(Cross(mesh.vertices[b] - mesh.vertices[a], mesh.vertices[c] - mesh.vertices[a]));
}

// V = 1/6 sum a . (b x c), relative to a vertex of the mesh so that far-away meshes keep their digits.
std::vector<Part> PartsOf(const Mesh& mesh, std::uint32_t count) {
  std::vector<Part> parts(count);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Part& part = parts[mesh.component[t]];
    std::array<Vec3, 3> c;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& v = mesh.vertices[mesh.triangles[t][k]];
      c[k] = v - mesh.vertices[0];
      part.lower = Min(part.lower, v);
      part.upper = Max(part.upper, v);
      part.closed = part.closed && mesh.neighbours[t][k] != kNoIndex;
    }
    part.volume_m3 += Dot(c[0], Cross(c[1], c[2])) / 6;
    part.area_m2 += TriangleArea(mesh, t);
  }
  return parts;
}

// One triangle of each of kSamples equal parts of the area, in the order of the mesh.
void PickSamples(const Mesh& mesh, std::vector<Part>& parts) {
  std::vector<double> passed(parts.size(), 0);
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    Part& part = parts[mesh.component[t]];
    double& area = passed[mesh.component[t]];
    area += TriangleArea(mesh, t);
    const double next = (static_cast<double>(part.samples.size()) + 0.5) / kSamples * part.area_m2;
    if (part.samples.size() < kSamples && area >= next) part.samples.push_back(t);
  }
}

// Mean winding number on the part itself. Its front lies 1/2 lower, its back 1/2 higher: a wall of a solid has
// n + 1/2 with n >= 0 solids in front of it, an inside-out one less than 0   (R.6)
double WindingOn(const Mesh& mesh, const WindingTree& tree, const Part& part) {
  double sum = 0;
  for (const std::uint32_t t : part.samples) {
    const auto& [a, b, c] = mesh.triangles[t];
    sum += tree.At((1.0 / 3) * (mesh.vertices[a] + mesh.vertices[b] + mesh.vertices[c]), t);
  }
  return part.samples.empty() ? 0 : sum / static_cast<double>(part.samples.size());
}

void FlipParts(Mesh& mesh, const std::vector<bool>& flip) {
  for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
    if (flip[mesh.component[t]]) Flip(mesh, t);
  }
}

std::vector<std::uint32_t> LargestFirst(const std::vector<Part>& parts) {
  std::vector<std::uint32_t> order(parts.size());
  std::iota(order.begin(), order.end(), 0U);
  std::stable_sort(order.begin(), order.end(),
                   [&](std::uint32_t a, std::uint32_t b) { return parts[a].area_m2 > parts[b].area_m2; });
  if (order.size() > kMaxAsked) order.resize(kMaxAsked);
  return order;
}

// Of the parts that are wrong, those that lie in no other wrong one are flipped; what they contain is checked again,
// because its winding number counts them.
std::vector<bool> OutermostWrong(const std::vector<Part>& parts, const std::vector<std::uint32_t>& wrong) {
  std::vector<bool> flip(parts.size(), false);
  for (const std::uint32_t inner : wrong) {
    flip[inner] = std::none_of(wrong.begin(), wrong.end(), [&](std::uint32_t outer) {
      return outer != inner && PartContains(parts[outer], parts[inner]);
    });
  }
  return flip;
}

void TurnByWinding(Mesh& mesh, std::vector<Part>& parts, OrientReport& report) {
  PickSamples(mesh, parts);
  const std::vector<std::uint32_t> asked = LargestFirst(parts);
  WindingTree tree(mesh);
  std::vector<double> winding(parts.size(), 0);
  for (int round = 0; round < kMaxRounds; ++round) {
    std::vector<std::uint32_t> wrong;
    for (const std::uint32_t p : asked) {
      winding[p] = WindingOn(mesh, tree, parts[p]);
      if (winding[p] < -kSure) wrong.push_back(p);
    }
    if (wrong.empty()) break;
    const std::vector<bool> flip = OutermostWrong(parts, wrong);
    FlipParts(mesh, flip);
    for (std::size_t p = 0; p < parts.size(); ++p) {
      if (!flip[p]) continue;
      parts[p].volume_m3 = -parts[p].volume_m3;
      ++report.flipped;
    }
    tree.Refit();
  }
  for (const std::uint32_t p : asked)
    report.cavities += parts[p].closed && parts[p].volume_m3 < 0 && winding[p] > kSure;
}

}  // namespace

OrientReport OrientOutwards(Mesh& mesh, std::uint32_t components) {
  OrientReport report;
  std::vector<Part> parts = PartsOf(mesh, components);
  const bool sound =
      std::all_of(parts.begin(), parts.end(), [](const Part& p) { return p.closed && !(p.volume_m3 < 0); });
  if (sound) return report;
  if (mesh.triangles.size() <= kMaxWindingTriangles && !(components == 1 && parts[0].closed)) {
    TurnByWinding(mesh, parts, report);
    return report;
  }
  // One closed component: the sign of its volume says all.
  std::vector<bool> flip(parts.size());
  for (std::size_t p = 0; p < parts.size(); ++p) {
    flip[p] = parts[p].closed && parts[p].volume_m3 < 0;
    report.flipped += flip[p];
  }
  FlipParts(mesh, flip);
  return report;
}

}  // namespace omni::haptics
