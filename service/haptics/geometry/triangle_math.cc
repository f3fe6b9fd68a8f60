#include "service/haptics/geometry/triangle_math.h"

namespace omni::haptics {
namespace {

double Component(const Vec3& v, int axis) noexcept { return axis == 0 ? v.x : (axis == 1 ? v.y : v.z); }

ClosestPoint AtVertex(const Corners& c, const Vec3& p, int k) noexcept {
  ClosestPoint result;
  result.point = c[static_cast<std::size_t>(k)];
  result.weights[static_cast<std::size_t>(k)] = 1;
  result.distance_squared = SquaredNorm(p - result.point);
  result.feature = Feature::kVertex;
  result.index = k;
  return result;
}

ClosestPoint AtEdge(const Corners& c, const Vec3& p, int k, double t) noexcept {
  const auto from = static_cast<std::size_t>(k);
  const auto to = static_cast<std::size_t>((k + 1) % 3);
  ClosestPoint result;
  result.point = c[from] + t * (c[to] - c[from]);
  result.weights[from] = 1 - t;
  result.weights[to] = t;
  result.distance_squared = SquaredNorm(p - result.point);
  result.feature = Feature::kEdge;
  result.index = k;
  return result;
}

// Without area the plane is unknown: the nearest of the three edges.
ClosestPoint ClosestOnNeedle(const Corners& c, const Vec3& p) noexcept {
  ClosestPoint best = AtVertex(c, p, 0);
  for (int k = 0; k < 3; ++k) {
    const Vec3& a = c[static_cast<std::size_t>(k)];
    const Vec3 ab = c[static_cast<std::size_t>((k + 1) % 3)] - a;
    const double length_squared = SquaredNorm(ab);
    const double t = length_squared > 0 ? Dot(p - a, ab) / length_squared : 0;
    const ClosestPoint candidate =
        t <= 0 ? AtVertex(c, p, k) : (t >= 1 ? AtVertex(c, p, (k + 1) % 3) : AtEdge(c, p, k, t));
    if (candidate.distance_squared < best.distance_squared) best = candidate;
  }
  return best;
}

}  // namespace

// Voronoi regions of the triangle in barycentric form   [Ericson, Real-Time Collision Detection, 5.1.5]
ClosestPoint ClosestOnTriangle(const Corners& c, const Vec3& p) noexcept {
  const Vec3 ab = c[1] - c[0];
  const Vec3 ac = c[2] - c[0];
  const Vec3 ap = p - c[0];
  const double d1 = Dot(ab, ap), d2 = Dot(ac, ap);
  if (d1 <= 0 && d2 <= 0) return AtVertex(c, p, 0);
  const Vec3 bp = p - c[1];
  const double d3 = Dot(ab, bp), d4 = Dot(ac, bp);
  if (d3 >= 0 && d4 <= d3) return AtVertex(c, p, 1);
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0 && d1 - d3 > 0) return AtEdge(c, p, 0, d1 / (d1 - d3));
  const Vec3 cp = p - c[2];
  const double d5 = Dot(ab, cp), d6 = Dot(ac, cp);
  if (d6 >= 0 && d5 <= d6) return AtVertex(c, p, 2);
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0 && d2 - d6 > 0) return AtEdge(c, p, 2, 1 - d2 / (d2 - d6));
  const double va = d3 * d6 - d5 * d4;
  const double on_bc = d4 - d3, off_bc = d5 - d6;
  if (va <= 0 && on_bc >= 0 && off_bc >= 0 && on_bc + off_bc > 0) return AtEdge(c, p, 1, on_bc / (on_bc + off_bc));
  const double sum = va + vb + vc;
  if (!(sum > 0)) return ClosestOnNeedle(c, p);
  const double v = vb / sum, w = vc / sum;
  ClosestPoint result;
  result.point = c[0] + v * ab + w * ac;
  result.weights = {1 - v - w, v, w};
  result.distance_squared = SquaredNorm(p - result.point);
  return result;
}

// The line becomes the z axis by a shear; 2D edge functions then show on which side of each edge it passes. Rounding
// can make an edge function zero but never give it the wrong sign, so no gap opens at edges and vertices [Woop, Benthin
// & Wald, Watertight Ray/Triangle Intersection, JCGT 2013]. On which side of the plane an end point lies depends on
// that point alone: the end of one segment and the start of the next agree, and no crossing falls between.
TriangleHit IntersectTriangle(const Corners& corners, const Vec3& start, const Vec3& end) noexcept {
  const Vec3 d = end - start;
  const int z =
      std::abs(d.x) > std::abs(d.y) ? (std::abs(d.x) > std::abs(d.z) ? 0 : 2) : (std::abs(d.y) > std::abs(d.z) ? 1 : 2);
  const double dz = Component(d, z);
  if (dz == 0) return {};
  const int x = dz > 0 ? (z + 1) % 3 : (z + 2) % 3;  // keeps the handedness
  const int y = dz > 0 ? (z + 2) % 3 : (z + 1) % 3;
  const double shear_x = Component(d, x) / dz, shear_y = Component(d, y) / dz;
  std::array<double, 3> px, py;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 v = corners[k] - start;
    px[k] = Component(v, x) - shear_x * Component(v, z);
    py[k] = Component(v, y) - shear_y * Component(v, z);
  }
  const double u = px[2] * py[1] - py[2] * px[1];
  const double v = px[0] * py[2] - py[0] * px[2];
  const double w = px[1] * py[0] - py[1] * px[0];
  const bool front = u >= 0 && v >= 0 && w >= 0;
  const bool back = u <= 0 && v <= 0 && w <= 0;
  if (!back && !front) return {};
  const Vec3 normal = AreaVector(corners);
  const double from = ScaledHeight(corners, normal, start), to = ScaledHeight(corners, normal, end);
  if ((from >= 0) == (to >= 0)) return {};
  return {true, from >= 0, from / (from - to)};
}

}  // namespace omni::haptics
