// The truth: exact distance and side of a point, by code that shares nothing with the renderer: a median-split tree in
// double for the nearest point and for rays, parity of a ray for the side; both checked against sums over all
// triangles.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "tests/bench/collision/body.h"
#include "tests/support/touch/nearest_on_triangle.h"

namespace omni::collision {

struct Nearest {
  double distance_squared = 1e300;
  Vec3 point;
  std::uint32_t triangle = haptics::kNoIndex;
};

class Oracle {
 public:
  explicit Oracle(const Body& body);

  // `hint`: a triangle that may be near, e.g. the last result.
  Nearest NearestTo(const Vec3& p, std::uint32_t hint = 0) const;
  // Odd number of crossings of the ray p + t e_z.
  bool IsInside(const Vec3& p) const;
  // Smallest t > 0 at which the ray from + t direction meets the surface; huge: never.
  double RayLength(const Vec3& from, const Vec3& direction) const;

 private:
  struct Node {
    Vec3 lower, upper;
    std::uint32_t begin, end;  // of order_
    std::uint32_t right;       // 0: leaf; the left child follows its parent
  };
  std::uint32_t Build(std::uint32_t begin, std::uint32_t end, std::span<const Vec3> centres);

  const Body& body_;
  std::vector<Node> nodes_;
  std::vector<std::uint32_t> order_;
  std::vector<std::array<Vec3, 3>> corners_;  // in the order of order_
};

// Sums over all triangles: squared distance, winding number.
struct Brute {
  double distance_squared = 1e300;
  double winding = 0;
};
std::vector<Brute> SumOverAll(const Body& body, std::span<const Vec3> points);

using support::NearestOnTriangle;

}  // namespace omni::collision
