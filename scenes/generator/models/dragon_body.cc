// Trunk, neck, tail, legs and dorsal ridges.
#include <algorithm>
#include <array>
#include <cmath>
#include <glm/geometric.hpp>

#include "scenes/generator/models/dragon_shape.h"

namespace omni::scenes {
namespace {

constexpr std::array<SpinePoint, 19> kSpine = {{
    {{-41.5, 23.0, 45.0}, 0.9},  // tail tip
    {{-45.5, 19.5, 41.5}, 1.2}, {{-49.5, 13.5, 36.5}, 1.5}, {{-50.5, 6.0, 31.5}, 1.9},
    {{-47.5, -1.0, 28.0}, 2.4}, {{-41.5, -4.5, 26.8}, 3.0}, {{-34.5, -4.0, 28.5}, 3.8},
    {{-28.0, -2.0, 32.2}, 4.8}, {{-22.5, -0.6, 35.8}, 5.7}, {{-16.5, 0, 37.8}, 6.6},  // hips
    {{-9.5, 0, 38.5}, 7.1},     {{-2.0, 0, 38.4}, 7.4},     {{5.5, 0, 39.0}, 8.0},    // chest
    {{12.0, 0, 41.2}, 7.6},     {{17.5, 0, 45.6}, 6.0},                               // neck
    {{21.3, 0.2, 51.2}, 4.8},   {{23.8, 0.7, 57.2}, 4.1},   {{26.8, 1.4, 62.6}, 3.8},
    {{31.3, 2.0, 66.0}, 3.9},  // head
}};

// Uniform Catmull-Rom.
template <class T>
T Spline(const T& p0, const T& p1, const T& p2, const T& p3, double u) {
  return 0.5 * (2.0 * p1 + (p2 - p0) * u + (2.0 * p0 - 5.0 * p1 + 4.0 * p2 - p3) * (u * u) +
                (3.0 * p1 - p0 - 3.0 * p2 + p3) * (u * u * u));
}

// The point of the dome over (x, y), lifted by `lift`.
Vec OnDome(double x, double y, double lift) {
  const double r = kDome_mm + lift;
  return {x, y, std::sqrt(r * r - x * x - y * y)};
}

struct Limb {
  std::array<Vec, 4> joint;  // from the trunk to the foot
  std::array<double, 4> radius;
  std::array<Vec, 3> toe;
};

void AddLimb(std::vector<Shape>& shapes, Limb limb, double side) {
  const auto flip = [side](Vec p) { return Vec(p.x, side * p.y, p.z); };
  for (std::size_t i = 0; i < 3; ++i) {
    shapes.push_back(RoundCone(flip(limb.joint[i]), limb.radius[i], flip(limb.joint[i + 1]), limb.radius[i + 1],
                               i == 0 ? 2.0 : 1.2, kSkin));
  }
  for (const Vec& toe : limb.toe) {
    const Vec foot = limb.joint[3];
    const Vec ahead = glm::normalize(toe - foot);
    const Vec knuckle = foot + (toe - foot) * 0.62 + glm::normalize(foot) * 0.7;
    shapes.push_back(RoundCone(flip(foot), 1.6, flip(knuckle), 1.25, 0.9, kSkin));
    shapes.push_back(RoundCone(flip(knuckle), 1.25, flip(toe), 1.0, 0.5, kSkin));
    const Vec claw_end = OnDome(toe.x + ahead.x * 3.0, toe.y + ahead.y * 3.0, 0.1);
    shapes.push_back(RoundCone(flip(toe + glm::normalize(toe) * 0.2), 0.8, flip(claw_end), 0.25, 0.25, kHorn));
  }
}

}  // namespace

SpinePoint SpineAt(double t) {
  const double s = std::clamp(t, 0.0, 1.0) * static_cast<double>(kSpine.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(s), kSpine.size() - 2);
  const double u = s - static_cast<double>(i);
  const SpinePoint& p0 = kSpine[i > 0 ? i - 1 : 0];
  const SpinePoint& p1 = kSpine[i];
  const SpinePoint& p2 = kSpine[i + 1];
  const SpinePoint& p3 = kSpine[std::min(i + 2, kSpine.size() - 1)];
  return {Spline(p0.position, p1.position, p2.position, p3.position, u),
          Spline(p0.radius, p1.radius, p2.radius, p3.radius, u)};
}

void AddBody(std::vector<Shape>& shapes) {
  constexpr int kSegments = 90;
  for (int i = 0; i < kSegments; ++i) {
    const SpinePoint a = SpineAt(static_cast<double>(i) / kSegments),
                     b = SpineAt(static_cast<double>(i + 1) / kSegments);
    shapes.push_back(RoundCone(a.position, a.radius, b.position, b.radius, 0.4, kSkin));
  }
  // A deeper chest and broader haunches than a tube has.
  shapes.push_back(RoundCone({11.5, 0, 38.2}, 6.2, {2.0, 0, 36.6}, 5.6, 3.0, kSkin));
  for (const double side : {-1.0, 1.0}) {
    shapes.push_back(RoundCone({10.5, side * 4.2, 41.5}, 4.6, {3.0, side * 3.6, 40.6}, 4.0, 3.0, kSkin));
    shapes.push_back(RoundCone({-12.0, side * 3.4, 37.6}, 4.8, {-17.5, side * 2.2, 37.0}, 3.8, 3.0, kSkin));
  }
}

void AddLegs(std::vector<Shape>& shapes) {
  const Limb front = {{Vec(9.5, 6.2, 38.5), Vec(5.0, 12.4, 40.6), Vec(13.6, 14.2, 36.0), OnDome(16.2, 14.2, 1.5)},
                      {4.6, 3.0, 2.0, 1.9},
                      {OnDome(20.6, 10.8, 1.0), OnDome(21.6, 14.6, 1.0), OnDome(19.2, 18.4, 1.0)}};
  const Limb hind = {{Vec(-13.0, 5.6, 37.4), Vec(-6.0, 13.6, 40.2), Vec(-17.4, 14.2, 37.0), OnDome(-13.2, 15.2, 1.6)},
                     {5.6, 3.6, 2.3, 2.1},
                     {OnDome(-8.4, 12.6, 1.0), OnDome(-7.8, 17.0, 1.0), OnDome(-10.6, 20.4, 1.0)}};
  for (const double side : {-1.0, 1.0}) {
    AddLimb(shapes, front, side);
    AddLimb(shapes, hind, side);
    // Heel spur and elbow spike.
    shapes.push_back(RoundCone({-17.6, side * 14.4, 37.2}, 1.0, {-20.8, side * 15.4, 36.0}, 0.3, 0.6, kHorn));
    shapes.push_back(RoundCone({4.6, side * 12.7, 40.8}, 1.2, {0.8, side * 14.2, 41.4}, 0.3, 0.6, kHorn));
  }
}

void AddTail(std::vector<Shape>& shapes) {
  // A spade: two slabs in the plane of the tail's end and a direction across it, barbs swept back, with a midrib.
  const Vec end = SpineAt(0).position;
  const Vec along = glm::normalize(end - SpineAt(0.05).position);
  const Vec across = glm::normalize(glm::cross(along, Vec(0.35, 0.9, 0.1)));
  const Vec tip = end + along * 9.5;
  for (const double side : {-1.0, 1.0}) {
    const Vec barb = end - along * 1.2 + across * (side * 5.6);
    const Vec notch = end + along * 0.8;
    shapes.push_back(Slab(notch, barb, end + along * 4.0 + across * (side * 3.0), 0.6, 0.5, kRidge));
    shapes.push_back(Slab(notch, end + along * 4.0 + across * (side * 3.0), tip, 0.6, 0.5, kRidge));
  }
  shapes.push_back(RoundCone(end, 1.0, tip, 0.5, 0.6, kSkin));
}

void AddRidges(std::vector<Shape>& shapes) {
  constexpr int kRidges = 27;
  for (int i = 0; i < kRidges; ++i) {
    const double t = 0.10 + 0.855 * i / (kRidges - 1);
    const SpinePoint at = SpineAt(t);
    const Vec along = glm::normalize(SpineAt(t + 0.01).position - SpineAt(t - 0.01).position);
    // The back's outward direction, perpendicular to the spine: up on the trunk, backwards on the neck.
    const Vec reference = t > 0.70 ? Vec(-0.75, 0, 0.66) : Vec(0, 0, 1);
    const Vec out = glm::normalize(reference - along * glm::dot(reference, along));
    // Low where the pen slides, higher on neck and tail.
    const double trunk = std::clamp(1 - std::abs(t - 0.60) / 0.16, 0.0, 1.0);
    const double height = (2.7 - 1.3 * trunk) * std::clamp(t / 0.3, 0.45, 1.0);
    const double half = 0.62 * (1.2 + 0.16 * at.radius) * std::clamp(t / 0.25, 0.6, 1.0);
    const Vec root = at.position + out * (at.radius - 0.9);
    shapes.push_back(Slab(root + along * half * 1.5, root - along * half * 1.7,
                          root - along * (half * 1.5) + out * (0.9 + height), 0.5, 0.5, kRidge));
  }
}

std::vector<Shape> DragonShapes() {
  std::vector<Shape> shapes;
  AddBody(shapes);
  AddLegs(shapes);
  AddTail(shapes);
  AddHead(shapes);
  AddWings(shapes);
  AddRidges(shapes);
  // It lies on the dome: its belly is cut to it.
  Shape dome = RoundCone({0, 0, 0}, kDome_mm + kClear_mm, {0, 0, -1}, kDome_mm + kClear_mm, 0.01, kSkin);
  dome.carve = true;
  shapes.push_back(dome);
  return shapes;
}

}  // namespace omni::scenes
