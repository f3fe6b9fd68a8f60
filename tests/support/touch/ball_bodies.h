// Closed bodies for a ball to slide over: boxes, sharp CAD parts, thin and concave ones, organic ones.
#pragma once

#include <array>
#include <string>
#include <utility>
#include <vector>

#include "tests/haptics/scenario.h"
#include "tests/support/touch/sculpt_body.h"

namespace omni::haptics {

using Polygon = std::vector<std::array<double, 2>>;  // x, y in m, counter-clockwise

namespace ball_bodies {

inline double Turn(const std::array<double, 2>& a, const std::array<double, 2>& b, const std::array<double, 2>& c) {
  return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
}

// Ear clipping.
inline std::vector<std::array<std::uint32_t, 3>> Triangulated(const Polygon& polygon) {
  std::vector<std::uint32_t> left;
  for (std::uint32_t i = 0; i < polygon.size(); ++i) left.push_back(i);
  std::vector<std::array<std::uint32_t, 3>> triangles;
  const auto is_ear = [&](std::size_t k) {
    const auto& a = polygon[left[(k + left.size() - 1) % left.size()]];
    const auto& b = polygon[left[k]];
    const auto& c = polygon[left[(k + 1) % left.size()]];
    if (!(Turn(a, b, c) > 0)) return false;
    return std::none_of(left.begin(), left.end(), [&](std::uint32_t i) {
      const auto& p = polygon[i];
      return p != a && p != b && p != c && Turn(a, b, p) >= 0 && Turn(b, c, p) >= 0 && Turn(c, a, p) >= 0;
    });
  };
  while (left.size() > 2) {
    std::size_t k = 0;
    while (k + 1 < left.size() && !is_ear(k)) ++k;
    triangles.push_back({left[(k + left.size() - 1) % left.size()], left[k], left[(k + 1) % left.size()]});
    left.erase(left.begin() + static_cast<std::ptrdiff_t>(k));
  }
  return triangles;
}

// The polygon, from z = -half to half, in as few triangles as possible.
inline InputObject Prism(const Polygon& polygon, double half_m) {
  InputObject object;
  const auto n = static_cast<std::uint32_t>(polygon.size());
  for (const double z : {-half_m, half_m}) {
    for (const auto& p : polygon) object.vertices_base_m.push_back({p[0], p[1], z});
  }
  for (const auto& [a, b, c] : Triangulated(polygon)) {
    AddTriangle(object, a, c, b);
    AddTriangle(object, n + a, n + b, n + c);
  }
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t next = (i + 1) % n;
    AddTriangle(object, i, next, n + next);
    AddTriangle(object, i, n + next, n + i);
  }
  return object;
}

inline Polygon Teeth(int count, double inner_m, double outer_m) {
  Polygon polygon;
  for (int k = 0; k < 4 * count; ++k) {
    const double angle = 2 * std::numbers::pi * (k + (k % 2 == 0 ? 0.15 : -0.15)) / (4 * count);
    const double r = k % 4 < 2 ? outer_m : inner_m;
    polygon.push_back({r * std::cos(angle), r * std::sin(angle)});
  }
  return polygon;
}

// A block with slots that are narrower and wider than balls of 0.5 to 3 mm.
inline Polygon Comb() {
  Polygon polygon{{-0.016, -0.008}, {0.016, -0.008}, {0.016, 0.008}};
  double x = 0.014;
  for (const double width_m : {0.0008, 0.002, 0.005, 0.009}) {
    for (const auto& [dx, y] : {std::pair{0.0, 0.008}, {0.0, -0.003}, {-width_m, -0.003}, {-width_m, 0.008}}) {
      polygon.push_back({x + dx, y});
    }
    x -= width_m + 0.0025;
  }
  polygon.push_back({-0.016, 0.008});
  return polygon;
}

inline Polygon Stairs() {
  Polygon polygon{{0.015, -0.008}, {0.015, 0.012}};
  for (int k = 0; k < 6; ++k) {
    polygon.push_back({0.010 - 0.004 * k, 0.012 - 0.003 * k});
    polygon.push_back({0.010 - 0.004 * k, 0.009 - 0.003 * k});
  }
  polygon.push_back({-0.015, -0.006});
  polygon.push_back({-0.015, -0.008});
  return polygon;
}

// A cone of needles.
inline InputObject Spike(int around, double radius_m, double height_m) {
  InputObject object;
  object.vertices_base_m = {{0, 0, height_m}, {0, 0, 0}};
  const auto n = static_cast<std::uint32_t>(around);
  for (int k = 0; k < around; ++k) {
    const double angle = 2 * std::numbers::pi * k / around;
    object.vertices_base_m.push_back({radius_m * std::cos(angle), radius_m * std::sin(angle), 0});
  }
  for (std::uint32_t k = 0; k < n; ++k) {
    AddTriangle(object, 0, 2 + k, 2 + (k + 1) % n);
    AddTriangle(object, 1, 2 + (k + 1) % n, 2 + k);
  }
  return object;
}

// A ring of a profile with a sharp groove on top.
inline InputObject GroovedRing(int around) {
  constexpr int kProfile = 6;
  constexpr std::array<std::array<double, 2>, kProfile> profile = {
      {{0.010, -0.006}, {0.022, -0.006}, {0.022, 0.006}, {0.0185, 0.006}, {0.016, 0.001}, {0.0135, 0.006}}};
  return Periodic(around, kProfile, [=](double u, double v) {
    const auto& p = profile[static_cast<std::size_t>(std::lround(v * kProfile / (2 * std::numbers::pi)))];
    return Vec3{p[0] * std::cos(u), p[0] * std::sin(u), p[1]};
  });
}

// A tube along a trefoil knot.
inline InputObject Knot(int along, int around, double radius_m) {
  constexpr double kSize_m = 0.006;
  const auto line = [](double t) {
    return Vec3{kSize_m * (std::sin(t) + 2 * std::sin(2 * t)), kSize_m * (std::cos(t) - 2 * std::cos(2 * t)),
                -1.6 * kSize_m * std::sin(3 * t)};
  };
  return Periodic(along, around, [=](double t, double v) {
    const Vec3 ahead = Normalized(line(t + 1e-4) - line(t - 1e-4));
    const Vec3 u = Normalized(Cross(ahead, Vec3{0, 0, 1} + 0.3 * ahead)), w = Cross(ahead, u);
    return line(t) + radius_m * (std::cos(v) * u + std::sin(v) * w);
  });
}

}  // namespace ball_bodies

struct BallBody {
  std::string name;
  InputObject object;
};

inline std::vector<BallBody> BallBodies() {
  using namespace ball_bodies;
  std::vector<BallBody> bodies;
  const auto add = [&](const char* name, InputObject object) {
    object.name = name;
    bodies.push_back({name, std::move(object)});
  };
  add("cube of 12", Block(1, {0.012, 0.012, 0.012}));
  add("fine box", Block(8, {0.02, 0.012, 0.006}));
  add("plate of 1 mm", Block(1, {0.015, 0.015, 0.0005}));
  add("wedge of 20 deg", Prism({{0, 0}, {0.03, -0.0053}, {0.03, 0.0053}}, 0.012));
  add("tetrahedron", sculpt::Tetrahedron(0.012));
  add("bracket",
      Prism({{-0.012, -0.012}, {0.012, -0.012}, {0.012, -0.006}, {-0.006, -0.006}, {-0.006, 0.012}, {-0.012, 0.012}},
            0.01));
  add("comb", Prism(Comb(), 0.01));
  add("stairs", Prism(Stairs(), 0.012));
  add("gear", Prism(Teeth(12, 0.012, 0.016), 0.005));
  add("spike", Spike(24, 0.006, 0.02));
  add("grooved ring", GroovedRing(48));
  add("torus", Periodic(40, 16, [](double u, double v) { return TorusPoint(0.014, 0.005, u, v); }));
  add("lump", sculpt::BumpyBall(12, 0.014, 0.12));
  add("knot", Knot(120, 10, 0.0035));
  return bodies;
}

// The same body in another orientation.
inline InputObject Turned(InputObject object, const Vec3& axis, double angle) {
  const Vec3 u = Normalized(axis);
  const double c = std::cos(angle), s = std::sin(angle);
  for (Vec3& v : object.vertices_base_m) v = c * v + s * Cross(u, v) + ((1 - c) * Dot(u, v)) * u;
  return object;
}

}  // namespace omni::haptics
