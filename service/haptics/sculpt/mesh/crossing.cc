#include "service/haptics/sculpt/mesh/crossing.h"

namespace omni::haptics::sculpt {
namespace {

constexpr double kFoldedCosine = -0.996;  // of two normals over an edge: a blade of 5 degrees

// The segment meets the triangle from one side to the other; one that lies in its plane does not.
bool Pierces(const Vec3& p, const Vec3& q, const Corners& c, const Vec3& area) noexcept {
  const double from = Dot(area, p - c[0]), to = Dot(area, q - c[0]);
  if (from == to || (from > 0 && to > 0) || (from < 0 && to < 0)) return false;
  const Vec3 x = p + (from / (from - to)) * (q - p);
  for (std::size_t k = 0; k < 3; ++k) {
    if (!(Dot(area, Cross(c[(k + 1) % 3] - c[k], x - c[k])) >= 0)) return false;
  }
  return true;
}

// All corners of `of` on one side of the plane.
bool IsBeside(const Corners& of, const Vec3& point, const Vec3& area) noexcept {
  const double a = Dot(area, of[0] - point), b = Dot(area, of[1] - point), c = Dot(area, of[2] - point);
  return (a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0);
}

}  // namespace

bool TrianglesCross(const Triangle& t, const Corners& a, const Triangle& u, const Corners& b) noexcept {
  if (!BoxesMeet(BoxOf(a), BoxOf(b))) return false;
  std::size_t shared = 0, at_t = 0, at_u = 0;
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t k = 0; k < 3; ++k) {
      if (t.vertex[i] != u.vertex[k]) continue;
      ++shared;
      at_t = i;
      at_u = k;
    }
  }
  const Vec3 a_area = AreaVector(a), b_area = AreaVector(b);
  if (shared >= 2) {
    const double along = Dot(a_area, b_area);
    return shared == 3 ||
           (along < 0 && along * along > kFoldedCosine * kFoldedCosine * SquaredNorm(a_area) * SquaredNorm(b_area));
  }
  if (shared == 1) {
    return Pierces(a[(at_t + 1) % 3], a[(at_t + 2) % 3], b, b_area) ||
           Pierces(b[(at_u + 1) % 3], b[(at_u + 2) % 3], a, a_area);
  }
  if (IsBeside(a, b[0], b_area) || IsBeside(b, a[0], a_area)) return false;
  for (std::size_t k = 0; k < 3; ++k) {
    if (Pierces(a[k], a[(k + 1) % 3], b, b_area) || Pierces(b[k], b[(k + 1) % 3], a, a_area)) return true;
  }
  return false;
}

bool CrossingCheck::CrossesAnother(std::uint32_t triangle, const std::array<std::uint32_t, 2>& without,
                                   std::uint32_t gone, std::uint32_t kept) {
  if (up_ != Vec3{}) return !FacesUp(mesh_.TriangleCorners(triangle), up_);  // a field of heights, if it stays one
  if (!fitted_) Fit();
  const auto named = [&](std::uint32_t index) {
    Triangle t = mesh_.GetTriangle(index);
    for (std::uint32_t& v : t.vertex) v = v == gone ? kept : v;
    return t;
  };
  const Triangle t = named(triangle);
  const Corners corners = mesh_.TriangleCorners(triangle);
  const auto crosses = [&](std::uint32_t other) {
    if (other == triangle || other == without[0] || other == without[1] || !mesh_.IsLive(other)) return false;
    return TrianglesCross(t, corners, named(other), mesh_.TriangleCorners(other));
  };
  return std::any_of(changed_.begin(), changed_.end(), crosses) || VisitNear(mesh_, BoxOf(corners), crosses);
}

}  // namespace omni::haptics::sculpt
