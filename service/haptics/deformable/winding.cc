#include "service/haptics/deformable/winding.h"

#include <numbers>

namespace omni::haptics {
namespace {

constexpr std::uint32_t kLeafTriangles = 6;
constexpr double kFarRadii = 2.3;  // beyond this many radii a cluster is a dipole (error about 1 %)

// Solid angle over 4 pi   [Van Oosterom & Strackee 1983]
double SolidAngleShare(const std::array<Vec3, 3>& t, const Vec3& p) {
  const Vec3 a = t[0] - p;
  const Vec3 b = t[1] - p;
  const Vec3 c = t[2] - p;
  const double la = Norm(a);
  const double lb = Norm(b);
  const double lc = Norm(c);
  const double up = Dot(a, Cross(b, c));
  const double down = la * lb * lc + Dot(a, b) * lc + Dot(b, c) * la + Dot(c, a) * lb;
  return std::atan2(up, down) / (2 * std::numbers::pi);
}

double Along(const Vec3& v, int axis) { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

}  // namespace

WindingField::WindingField(std::span<const Vec3> vertices, std::span<const std::array<std::uint32_t, 3>> triangles) {
  std::vector<std::array<Vec3, 3>> soup;
  soup.reserve(triangles.size());
  for (const auto& t : triangles) soup.push_back({vertices[t[0]], vertices[t[1]], vertices[t[2]]});
  std::vector<std::uint32_t> order(soup.size());
  for (std::uint32_t i = 0; i < order.size(); ++i) order[i] = i;
  if (!soup.empty()) Build(0, static_cast<std::uint32_t>(soup.size()), order, soup);
  corners_.reserve(soup.size());
  for (const std::uint32_t i : order) corners_.push_back(soup[i]);
}

std::uint32_t WindingField::Build(std::uint32_t first, std::uint32_t count, std::vector<std::uint32_t>& order,
                                  const std::vector<std::array<Vec3, 3>>& soup) {
  const std::uint32_t self = static_cast<std::uint32_t>(clusters_.size());
  Cluster cluster;
  cluster.first = first;
  cluster.count = count;
  double total = 0;
  Vec3 lower = soup[order[first]][0];
  Vec3 upper = lower;
  for (std::uint32_t k = first; k < first + count; ++k) {
    const auto& t = soup[order[k]];
    const Vec3 area = 0.5 * Cross(t[1] - t[0], t[2] - t[0]);
    const double size = Norm(area);
    cluster.area = cluster.area + area;
    cluster.centre = cluster.centre + (size / 3) * (t[0] + t[1] + t[2]);
    total += size;
    for (const Vec3& v : t) {
      lower = Min(lower, v);
      upper = Max(upper, v);
    }
  }
  cluster.centre = total > 0 ? (1 / total) * cluster.centre : 0.5 * (lower + upper);
  for (std::uint32_t k = first; k < first + count; ++k) {
    for (const Vec3& v : soup[order[k]]) cluster.radius_m = std::max(cluster.radius_m, Norm(v - cluster.centre));
  }
  clusters_.push_back(cluster);
  if (count <= kLeafTriangles) return self;
  const Vec3 extent = upper - lower;
  const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : (extent.y >= extent.z ? 1 : 2);
  const auto middle = order.begin() + first + count / 2;
  std::nth_element(order.begin() + first, middle, order.begin() + first + count, [&](std::uint32_t a, std::uint32_t b) {
    const double ka = Along(soup[a][0], axis) + Along(soup[a][1], axis) + Along(soup[a][2], axis);
    const double kb = Along(soup[b][0], axis) + Along(soup[b][1], axis) + Along(soup[b][2], axis);
    return ka < kb || (ka == kb && a < b);
  });
  Build(first, count / 2, order, soup);
  const std::uint32_t right = Build(first + count / 2, count - count / 2, order, soup);
  clusters_[self].right = right;
  return self;
}

double WindingField::At(const Vec3& p) const {
  if (clusters_.empty()) return 0;
  double sum = 0;
  std::uint32_t stack[64];
  int size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const std::uint32_t index = stack[--size];
    const Cluster& cluster = clusters_[index];
    const Vec3 d = cluster.centre - p;
    const double distance = Norm(d);
    if (distance > kFarRadii * cluster.radius_m) {
      sum += Dot(cluster.area, d) / (4 * std::numbers::pi * distance * distance * distance);
    } else if (cluster.right == 0) {
      for (std::uint32_t k = 0; k < cluster.count; ++k) sum += SolidAngleShare(corners_[cluster.first + k], p);
    } else {
      stack[size++] = index + 1;
      stack[size++] = cluster.right;
    }
  }
  return sum;
}

}  // namespace omni::haptics
