// Meshes for a ball to roll on, and what every resting ball obeys, checked by brute force over all triangles.
#pragma once

#include <vector>

#include "service/haptics/contact/ball/ball_proxy.h"
#include "tests/haptics/oracle.h"

namespace omni::haptics {

// A sheet along y over the points (x, z) in metres, in that order, open at its rim; facing up where x grows. Every
// piece is cut into `along` x `across` rectangles.
inline InputObject ProfileSheet(const std::vector<std::array<double, 2>>& profile, double half_m, int along = 1,
                                int across = 1) {
  InputObject sheet;
  sheet.name = "sheet";
  std::vector<std::array<double, 2>> points;
  for (std::size_t i = 0; i + 1 < profile.size(); ++i) {
    for (int k = 0; k < along; ++k) {
      const double s = static_cast<double>(k) / along;
      points.push_back({profile[i][0] + s * (profile[i + 1][0] - profile[i][0]),
                        profile[i][1] + s * (profile[i + 1][1] - profile[i][1])});
    }
  }
  points.push_back(profile.back());
  const auto n = static_cast<std::uint32_t>(points.size());
  for (int j = 0; j <= across; ++j) {
    for (const auto& p : points) sheet.vertices_base_m.push_back({p[0], half_m * (2.0 * j / across - 1), p[1]});
  }
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(across); ++j) {
    for (std::uint32_t i = 0; i + 1 < n; ++i) {
      const std::uint32_t a = j * n + i, b = a + 1, c = b + n, d = a + n;
      AddTriangle(sheet, a, b, c);
      AddTriangle(sheet, a, c, d);
    }
  }
  sheet.double_sided = true;
  return sheet;
}

// A ball on the first object of a scene.
class BallScenario {
 public:
  BallScenario(Scene scene, double radius_m, const Vec3& start)
      : scene_(std::move(scene)), surface_(scene_, {}), radius_m_(radius_m) {
    Restart(start);
  }
  void Restart(const Vec3& start) {
    const bool closed = (object().flags & kClosed) != 0 && (object().flags & kDoubleSided) == 0;
    state = StartBall(surface_, object().root, closed ? Inside::kBySign : Inside::kNone, radius_m_, start);
    MoveTo(start);
  }
  const BallContact& MoveTo(const Vec3& tip) {
    contact = FollowBall(surface_, object().root, radius_m_, tip, state);
    return contact;
  }
  const BallContact& Slide(const Vec3& from, const Vec3& to, int ticks) {
    for (int k = 1; k <= ticks; ++k) MoveTo(from + (static_cast<double>(k) / ticks) * (to - from));
    return contact;
  }
  const BallContact& Rest(int ticks) {
    for (int k = 0; k < ticks; ++k) MoveTo(state.device_point_m);
    return contact;
  }
  Vec3 Push() const { return state.centre_m - state.device_point_m; }
  // Sum of what the touches say, per unit of push: the push's direction.
  Vec3 SumOfShares() const {
    Vec3 sum;
    for (int k = 0; k < contact.touch_count; ++k) {
      const BallTouch& touch = contact.touches[static_cast<std::size_t>(k)];
      sum = sum + touch.share * touch.normal;
    }
    return sum;
  }
  // Over the radius: 0 touches, < 0 too near.
  double Gap() const {
    return (std::sqrt(BruteNearest(scene_, surface_, state.centre_m).closest.distance_squared) - radius_m_) / radius_m_;
  }
  const Object& object() const { return scene_.objects()[0]; }
  const Surface& surface() const { return surface_; }
  const Scene& scene() const { return scene_; }
  double radius_m() const { return radius_m_; }

  BallState state;
  BallContact contact;

 private:
  Scene scene_;
  Surface surface_;
  double radius_m_;
};

// How much nearer to the device point, in radii, a ball is at the best of many free places within `reach` radii of
// where it rests: none is nearer at a local minimum.
inline double BestGain(const BallScenario& ball, double reach, int tries, Random& random) {
  const Vec3 centre = ball.state.centre_m, tip = ball.state.device_point_m;
  std::vector<Corners> near;
  for (std::uint32_t t = 0; t < ball.scene().header().triangle_count; ++t) {
    const Corners corners = ball.surface().TriangleCorners(t);
    const double limit_m = ball.radius_m() * (1 + reach);
    if (ClosestOnTriangle(corners, centre).distance_squared < limit_m * limit_m) near.push_back(corners);
  }
  double best = 0;
  for (int k = 0; k < tries; ++k) {
    const double scale = reach * ball.radius_m() * std::pow(0.5, static_cast<double>(random.Next() % 4));
    const Vec3 at = centre + scale * Normalized(random.InBox(1));
    const double gain = (Norm(centre - tip) - Norm(at - tip)) / ball.radius_m();
    if (gain <= best) continue;
    const bool free = std::all_of(near.begin(), near.end(), [&](const Corners& corners) {
      return ClosestOnTriangle(corners, at).distance_squared >= ball.radius_m() * ball.radius_m();
    });
    if (free) best = gain;
  }
  return best;
}

}  // namespace omni::haptics
