// Winding number and distance as sums over all triangles, eight points side by side: 1e4 points on 1e6 triangles are
// 1e10 pairs.
#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/bench/collision/oracle.h"

namespace omni::collision {
namespace {

constexpr std::size_t kLanes = 8;

struct Lanes {
  double x[kLanes], y[kLanes], z[kLanes];
  double angle[kLanes]{}, distance_squared[kLanes];
};

// Solid angle and distance of one triangle at eight points. tan(omega / 2) = num / den [van Oosterom & Strackee 1983];
// `rest` marks where the series is not valid.
struct Shares {
  double angle[kLanes], num[kLanes], den[kLanes], rest[kLanes], least[kLanes];
};

__attribute__((target_clones("avx2", "default"))) void ShareOf(const Vec3& a, const Vec3& b, const Vec3& c,
                                                               const Lanes& p, Shares& s) {
  for (std::size_t k = 0; k < kLanes; ++k) {
    const double ax = a.x - p.x[k], ay = a.y - p.y[k], az = a.z - p.z[k];
    const double bx = b.x - p.x[k], by = b.y - p.y[k], bz = b.z - p.z[k];
    const double cx = c.x - p.x[k], cy = c.y - p.y[k], cz = c.z - p.z[k];
    const double la = std::sqrt(ax * ax + ay * ay + az * az), lb = std::sqrt(bx * bx + by * by + bz * bz),
                 lc = std::sqrt(cx * cx + cy * cy + cz * cz);
    const double num = ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx);
    const double den = la * lb * lc + (ax * bx + ay * by + az * bz) * lc + (bx * cx + by * cy + bz * cz) * la +
                       (cx * ax + cy * ay + cz * az) * lb;
    const double small = std::abs(num) < 0.03 * den ? 1 : 0;
    const double x = num / (den != 0 ? den : 1);
    s.angle[k] = small * x * (1 - x * x * (1.0 / 3 - x * x * 0.2));
    s.num[k] = num;
    s.den[k] = den;
    s.rest[k] = 1 - small;
    const double ab = la < lb ? la : lb;
    s.least[k] = ab < lc ? ab : lc;
  }
}

void SumBlock(const Body& body, Lanes& p) {
  for (const auto& t : body.triangles) {
    const Vec3 &a = body.vertices[t[0]], &b = body.vertices[t[1]], &c = body.vertices[t[2]];
    const double edge = std::sqrt(std::max({SquaredNorm(b - a), SquaredNorm(c - b), SquaredNorm(a - c)}));
    Shares s;
    ShareOf(a, b, c, p, s);
    for (std::size_t k = 0; k < kLanes; ++k) {
      p.angle[k] += s.rest[k] != 0 ? std::atan2(s.num[k], s.den[k]) : s.angle[k];
      const double least = s.least[k] - edge;  // no point of the triangle is nearer
      if (least > 0 && least * least > p.distance_squared[k]) continue;
      const Vec3 at{p.x[k], p.y[k], p.z[k]};
      p.distance_squared[k] = std::min(p.distance_squared[k], SquaredNorm(NearestOnTriangle({a, b, c}, at) - at));
    }
  }
}

}  // namespace

std::vector<Brute> SumOverAll(const Body& body, std::span<const Vec3> points) {
  std::vector<Brute> sums(points.size());
  for (std::size_t begin = 0; begin < points.size(); begin += kLanes) {
    Lanes lanes;
    for (std::size_t k = 0; k < kLanes; ++k) {
      const Vec3& p = points[std::min(begin + k, points.size() - 1)];
      lanes.x[k] = p.x;
      lanes.y[k] = p.y;
      lanes.z[k] = p.z;
      lanes.distance_squared[k] = 1e300;
    }
    SumBlock(body, lanes);
    for (std::size_t k = 0; k < kLanes && begin + k < points.size(); ++k) {
      sums[begin + k] = {lanes.distance_squared[k], lanes.angle[k] / (2 * std::numbers::pi)};
    }
  }
  return sums;
}

}  // namespace omni::collision
