#include "service/haptics/deformable/build/fem.h"

#include <Eigen/Core>
#include <Eigen/LU>

namespace omni::haptics {
namespace {

constexpr int kCuts = 4;            // per edge, of a triangle for quadrature
constexpr double kSameWay = 0.35;   // cosine: triangles turned away more are another side of the body
constexpr double kAlike = 0.8;      // cosine: points turned away more say nothing about the curvature here
constexpr double kDeepest = 1.0;    // of the radius: further below the tangent plane does not count
constexpr std::size_t kFewest = 9;  // points for a fit of curvature

struct Offset {
  double across_m, height_m;
};

Offset OffsetFrom(const SurfacePatch& at, const Vec3& p) {
  const Vec3 d = p - at.point_base_m;
  const double height = Dot(d, at.normal);
  return {std::sqrt(std::max(0.0, SquaredNorm(d) - height * height)), height};
}

// Shares of the six nodes of a quadratic triangle at barycentric coordinates l.
std::array<double, 6> TriangleShapes(const std::array<double, 3>& l) {
  return {l[0] * (2 * l[0] - 1), l[1] * (2 * l[1] - 1), l[2] * (2 * l[2] - 1),
          4 * l[0] * l[1],       4 * l[1] * l[2],       4 * l[2] * l[0]};
}

// Least squares z = a + b x + c y + (k1 x^2 + 2 k12 x y + k2 y^2) / 2 in the tangent plane; -(k1 + k2) / 2.
double FitCurvature(const SurfacePatch& at, const std::vector<Vec3>& points, double radius_m) {
  if (points.size() < kFewest) return 0;
  const Vec3 helper = std::abs(at.normal.x) < 0.8 ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
  const Vec3 u = Normalized(Cross(at.normal, helper));
  const Vec3 v = Cross(at.normal, u);
  Eigen::Matrix<double, 6, 6> normal_matrix = Eigen::Matrix<double, 6, 6>::Zero();
  Eigen::Matrix<double, 6, 1> right = Eigen::Matrix<double, 6, 1>::Zero();
  for (const Vec3& p : points) {
    const Vec3 d = (1 / radius_m) * (p - at.point_base_m);
    const double x = Dot(d, u);
    const double y = Dot(d, v);
    Eigen::Matrix<double, 6, 1> row;
    row << 1, x, y, 0.5 * x * x, x * y, 0.5 * y * y;
    normal_matrix += row * row.transpose();
    right += Dot(d, at.normal) * row;
  }
  const Eigen::FullPivLU<Eigen::Matrix<double, 6, 6>> lu(normal_matrix);
  if (!lu.isInvertible()) return 0;
  const Eigen::Matrix<double, 6, 1> fit = lu.solve(right);
  return -0.5 * (fit[3] + fit[5]) / radius_m;
}

}  // namespace

PatchLoad SpreadLoad(const QuadraticMesh& mesh, const SurfacePatch& at, double radius_m) {
  PatchLoad load{at.normal, {}};
  double total = 0;
  for (const auto& t : mesh.surface) {
    const std::array<Vec3, 3> x{mesh.nodes_base_m[t[0]], mesh.nodes_base_m[t[1]], mesh.nodes_base_m[t[2]]};
    const Vec3 centre = (1.0 / 3) * (x[0] + x[1] + x[2]);
    const double reach = radius_m + std::max({Norm(x[0] - centre), Norm(x[1] - centre), Norm(x[2] - centre)});
    if (SquaredNorm(centre - at.point_base_m) > 2 * reach * reach) continue;
    const Vec3 area = Cross(x[1] - x[0], x[2] - x[0]);
    if (Dot(area, at.normal) < kSameWay * Norm(area)) continue;
    std::array<double, 6> sum{};
    const auto sample = [&](double l0, double l1) {
      const std::array<double, 3> l{l0, l1, 1 - l0 - l1};
      const Offset o = OffsetFrom(at, l[0] * x[0] + l[1] * x[1] + l[2] * x[2]);
      const double r = o.across_m / radius_m;
      if (!(r < 1 && std::abs(o.height_m) < kDeepest * radius_m)) return;
      const double p = std::sqrt(1 - r * r) * Dot(area, at.normal);
      const auto n = TriangleShapes(l);
      for (std::size_t k = 0; k < 6; ++k) sum[k] += p * n[k];
    };
    for (int i = 0; i < kCuts; ++i) {
      for (int j = 0; i + j < kCuts; ++j) {
        sample((i + 1.0 / 3) / kCuts, (j + 1.0 / 3) / kCuts);
        if (i + j < kCuts - 1) sample((i + 2.0 / 3) / kCuts, (j + 2.0 / 3) / kCuts);
      }
    }
    for (std::size_t k = 0; k < 6; ++k) {
      if (sum[k] == 0) continue;
      load.shares.emplace_back(t[k], sum[k]);
      total += sum[k];
    }
  }
  for (auto& [node, share] : load.shares) share /= total;
  return load;
}

std::vector<SurfacePatch> MeasurePatches(const QuadraticMesh& mesh, const std::vector<std::uint32_t>& nodes,
                                         double radius_m) {
  std::vector<Vec3> normal(mesh.nodes_base_m.size());
  for (const auto& t : mesh.surface) {
    const Vec3 area =
        Cross(mesh.nodes_base_m[t[1]] - mesh.nodes_base_m[t[0]], mesh.nodes_base_m[t[2]] - mesh.nodes_base_m[t[0]]);
    for (std::size_t k = 0; k < 3; ++k) normal[t[k]] = normal[t[k]] + area;
  }
  std::vector<SurfacePatch> patches;
  for (const std::uint32_t n : nodes) {
    SurfacePatch patch{mesh.nodes_base_m[n], Normalized(normal[n]), 0};
    std::vector<Vec3> points;
    for (const std::uint32_t m : nodes) {
      const Offset o = OffsetFrom(patch, mesh.nodes_base_m[m]);
      const bool near = o.across_m < radius_m && std::abs(o.height_m) < kDeepest * radius_m;
      if (near && Dot(Normalized(normal[m]), patch.normal) > kAlike) points.push_back(mesh.nodes_base_m[m]);
    }
    patch.curvature_1_m = FitCurvature(patch, points, radius_m);
    patches.push_back(patch);
  }
  return patches;
}

}  // namespace omni::haptics
