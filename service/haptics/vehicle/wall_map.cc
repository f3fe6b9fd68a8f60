#include "service/haptics/vehicle/wall_map.h"

#include <array>
#include <optional>

namespace omni::haptics {
namespace {

// Motions that approach by less than this share of their length slide along: rounding must not stop them.
constexpr double kGrazing = 1e-9;
constexpr double kOverlapping = 1 - 1e-9;  // of the squared radius: nearer is an overlap, not a touch

double Cross2(const Vec3& a, const Vec3& b) noexcept { return a.x * b.y - a.y * b.x; }

// Calls visit(segment) for those in boxes that accept(node).
template <class Accept, class Visit>
void Search(const WallMap& walls, Accept&& accept, Visit&& visit) noexcept {
  if (walls.nodes.empty()) return;
  std::array<std::uint32_t, kMaxWallDepth + 2> stack;
  std::size_t size = 0;
  stack[size++] = 0;
  while (size > 0) {
    const WallNode& node = walls.nodes[stack[--size]];
    if (!accept(node)) continue;
    for (std::uint32_t k = 0; k < node.count; ++k) visit(walls.segments[node.first + k]);
    if (node.count > 0) continue;
    stack[size++] = node.first + 1;
    stack[size++] = node.first;
  }
}

Vec3 NearestOn(const WallSegment& s, const Vec3& p) noexcept {
  const Vec3 a{s.ax, s.ay, 0}, along{s.bx - s.ax, s.by - s.ay, 0};
  const double length_squared = SquaredNorm(along);
  if (!(length_squared > 0)) return a;
  return a + std::clamp(Dot(p - a, along) / length_squared, 0.0, 1.0) * along;
}

// From the wall to p; across the wall, against the motion, if p lies on it.
Vec3 NormalAt(const WallSegment& s, const Vec3& p, const Vec3& motion) noexcept {
  const Vec3 away = p - NearestOn(s, p);
  if (SquaredNorm(away) > 0) return Normalized(away);
  const Vec3 across = base::Normalized({s.ay - s.by, s.bx - s.ax, 0});
  if (across == Vec3{}) return Normalized(-motion);
  return Dot(across, motion) > 0 ? -across : across;
}

// Smaller root of |p + t d - c|^2 = r^2 from outside, without cancellation   (8.7)
std::optional<double> EnterCircle(const Vec3& c, double radius_m, const Vec3& p, const Vec3& d) noexcept {
  const Vec3 from = p - c;
  const double half_b = Dot(from, d);
  if (!(half_b < 0)) return std::nullopt;
  const double outside = SquaredNorm(from) - radius_m * radius_m;
  const double discriminant = half_b * half_b - SquaredNorm(d) * outside;
  if (!(discriminant >= 0)) return std::nullopt;
  return std::max(0.0, outside / (std::sqrt(discriminant) - half_b));
}

// Where the moving point enters the segment thickened by r: through a long side, or through the circle around an end.
// The set is the union of the two circles and a box between them, so the earliest entry into a part is the entry. (8.6)
std::optional<double> EnterCapsule(const WallSegment& s, double radius_m, const Vec3& p, const Vec3& d) noexcept {
  const Vec3 a{s.ax, s.ay, 0}, b{s.bx, s.by, 0};
  std::optional<double> first = EnterCircle(a, radius_m, p, d);
  if (const auto t = EnterCircle(b, radius_m, p, d); t && !(first && *first <= *t)) first = t;
  const Vec3 along = b - a;
  const double length_m = Norm(along);
  if (!(length_m > 0)) return first;
  const double height = Cross2(along, p - a) / length_m;  // signed distance from the line
  const double approach = -std::copysign(1.0, height) * Cross2(along, d) / length_m;
  const double gap_m = std::abs(height) - radius_m;
  // A point that slides along the side may lie a rounding error within it.
  if (!(gap_m >= -1e-9 * radius_m && approach > 0)) return first;
  const double t = std::max(0.0, gap_m) / approach;
  const double place = Dot(p + t * d - a, along);
  if (place >= 0 && place <= length_m * length_m && !(first && *first <= t)) first = t;
  return first;
}

// Slab test of the motion up to `share` against the box grown by `margin_m`.
bool Reaches(const WallNode& node, const Vec3& p, const Vec3& d, double margin_m, double share) noexcept {
  double from = 0, to = share;
  const double start[2] = {p.x, p.y}, step[2] = {d.x, d.y};
  for (int k = 0; k < 2; ++k) {
    const double lower = node.lower[k] - margin_m - start[k], upper = node.upper[k] + margin_m - start[k];
    if (std::abs(step[k]) < 1e-12) {
      if (lower > 0 || upper < 0) return false;
      continue;
    }
    const double one = lower / step[k], other = upper / step[k];
    from = std::max(from, std::min(one, other));
    to = std::min(to, std::max(one, other));
  }
  return from <= to;
}

}  // namespace

Wall NearestWall(const WallMap& walls, const Vec3& p, double reach_m) noexcept {
  const Vec3 at{p.x, p.y, 0};
  Wall wall;
  wall.distance_m = reach_m;
  const auto accept = [&](const WallNode& n) {
    const double dx = std::max({n.lower[0] - at.x, 0.0, at.x - n.upper[0]});
    const double dy = std::max({n.lower[1] - at.y, 0.0, at.y - n.upper[1]});
    return dx * dx + dy * dy < wall.distance_m * wall.distance_m;
  };
  Search(walls, accept, [&](const WallSegment& s) {
    const double distance_m = Norm(at - NearestOn(s, at));
    if (distance_m < wall.distance_m) wall = {true, distance_m, NormalAt(s, at, {}), s.material};
  });
  return wall;
}

WallTouch FirstTouch(const WallMap& walls, const Vec3& p, const Vec3& motion, double radius_m) noexcept {
  const Vec3 at{p.x, p.y, 0}, d{motion.x, motion.y, 0};
  const double length_m = Norm(d);
  WallTouch touch;
  if (!(length_m > 0)) return touch;
  const double margin_m = radius_m * (1 + 1e-9) + 1e-9 + 1e-12 * length_m;
  const auto accept = [&](const WallNode& n) { return Reaches(n, at, d, margin_m, touch.share); };
  Search(walls, accept, [&](const WallSegment& s) {
    const double away_squared = SquaredNorm(at - NearestOn(s, at));
    if (away_squared < kOverlapping * radius_m * radius_m) touch.overlaps = true;
    double t = 0;
    if (away_squared > radius_m * radius_m) {
      const auto entry = EnterCapsule(s, radius_m, at, d);
      if (!entry) return;
      t = *entry;
    }
    if (t > 1 || (touch.found && t >= touch.share)) return;
    // Distance to a segment is convex along the motion: what does not approach here never will.
    const Vec3 normal = NormalAt(s, at + t * d, d);
    if (Dot(normal, d) < -kGrazing * length_m) touch = {true, t, normal, s.material, touch.overlaps};
  });
  return touch;
}

}  // namespace omni::haptics
