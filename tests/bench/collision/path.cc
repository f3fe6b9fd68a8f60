#include "tests/bench/collision/path.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "tests/haptics/scenario.h"

namespace omni::collision {
namespace {

// Walks straight over the triangles and turns slowly.
class Walker {
 public:
  Walker(const Body& body, std::uint64_t seed) : body_(body), random_(seed) {
    triangle_ = static_cast<std::uint32_t>(random_.Next() % body.triangles.size());
    const auto& v = body.triangles[triangle_];
    point_ = (1.0 / 3) * (body.vertices[v[0]] + body.vertices[v[1]] + body.vertices[v[2]]);
    heading_ = random_.InBox(1);
  }

  void Advance(double length_m) {
    turn_ = std::clamp(turn_ + random_.Uniform(-0.3, 0.3), -1.0, 1.0);
    Vec3 normal = Area();
    heading_ = Normalized(heading_ + (20 * turn_ * length_m) * Cross(Normalized(normal), heading_));
    for (int crossed = 0; crossed < 10'000 && length_m > 0; ++crossed) {
      normal = Normalized(Area());
      heading_ = Normalized(heading_ - Dot(heading_, normal) * normal);
      length_m -= ToEdge(normal, length_m);
    }
  }

  const Vec3& point() const { return point_; }
  Vec3 Normal() const {  // between those of the corners
    const auto& v = body_.triangles[triangle_];
    const Vec3 area = Area();
    Vec3 sum;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3 opposite = Cross(body_.vertices[v[(k + 1) % 3]] - point_, body_.vertices[v[(k + 2) % 3]] - point_);
      sum = sum + std::max(0.0, Dot(opposite, area) / SquaredNorm(area)) * body_.normals[v[k]];
    }
    return Normalized(sum);
  }

 private:
  Vec3 Area() const {
    const auto& v = body_.triangles[triangle_];
    return Cross(body_.vertices[v[1]] - body_.vertices[v[0]], body_.vertices[v[2]] - body_.vertices[v[0]]);
  }

  // Moves to the edge the heading leads out of, at most `length_m`, and into the next triangle. Returns the distance
  // moved.
  double ToEdge(const Vec3& normal, double length_m) {
    const auto& v = body_.triangles[triangle_];
    double way_m = length_m;
    std::size_t out = 3;
    for (std::size_t k = 0; k < 3; ++k) {
      const Vec3& a = body_.vertices[v[k]];
      const Vec3 inwards = Cross(normal, body_.vertices[v[(k + 1) % 3]] - a);
      const double speed = -Dot(inwards, heading_), height = std::max(0.0, Dot(inwards, point_ - a));
      if (speed > 0 && height / speed < way_m) {
        way_m = height / speed;
        out = k;
      }
    }
    point_ = point_ + way_m * heading_;
    if (out == 3) return way_m;
    const std::uint32_t next = body_.neighbours[triangle_][out];
    if (next == haptics::kNoIndex) {
      heading_ = -heading_;
    } else {
      triangle_ = next;
    }
    return way_m + 1e-9;  // so that turning at a corner ends
  }

  const Body& body_;
  haptics::Random random_;
  std::uint32_t triangle_ = 0;
  Vec3 point_, heading_;
  double turn_ = 0;
};

}  // namespace

// The tip is over the walker along a normal that follows the surface's a little late; the walker is driven so that the
// tip moves by step_m, and where it would jump, the jump is divided.
std::vector<Vec3> MakePath(const Body& body, const Oracle& oracle, const Style& style, std::size_t ticks,
                           std::uint64_t seed) {
  Walker walker(body, seed);
  std::vector<Vec3> path;
  Vec3 normal = walker.Normal();
  double walked_m = 0;
  while (path.size() < ticks) {
    const double piece_m = 0.25 * style.step_m;
    walker.Advance(piece_m);
    walked_m += piece_m;
    normal = Normalized(normal + std::min(1.0, piece_m / 1e-3) * walker.Normal());
    const double deepest_m = -std::min(kDeepest * oracle.RayLength(walker.point(), -normal), kDeepest_m);
    const double low_m = style.lowest_m == 0 ? deepest_m : std::max(deepest_m, style.lowest_m);
    const double high_m = std::max(low_m, style.highest_m);
    const double phase = 0.5 + 0.5 * std::cos(2 * std::numbers::pi * walked_m / style.wave_m);
    const Vec3 tip = walker.point() + (low_m + phase * (high_m - low_m)) * normal;
    if (path.empty()) path.push_back(tip);
    const double way_m = Norm(tip - path.back());
    const Vec3 from = path.back();
    const auto steps = static_cast<std::size_t>(way_m / style.step_m);
    for (std::size_t k = 1; k <= steps && path.size() < ticks; ++k) {
      path.push_back(from + (static_cast<double>(k) * style.step_m / way_m) * (tip - from));
    }
  }
  return path;
}

}  // namespace omni::collision
