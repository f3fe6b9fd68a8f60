// Thirty closed bodies for tips of any size: those of ball_bodies.h, the regular polyhedra, profiles, sharp and thin
// ones. Some tens of millimetres, around the origin.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "tests/support/touch/ball_bodies.h"

namespace omni::haptics {

namespace tip_bodies {

inline Polygon Regular(int corners, double radius_m) {
  Polygon polygon;
  for (int k = 0; k < corners; ++k) {
    const double angle = 2 * std::numbers::pi * k / corners;
    polygon.push_back({radius_m * std::cos(angle), radius_m * std::sin(angle)});
  }
  return polygon;
}

inline Polygon Star(int rays, double inner_m, double outer_m) {
  Polygon polygon = Regular(2 * rays, outer_m);
  for (std::size_t k = 1; k < polygon.size(); k += 2) {
    for (double& x : polygon[k]) x *= inner_m / outer_m;
  }
  return polygon;
}

// In millimetres.
inline Polygon Outline(const std::vector<std::array<double, 2>>& points_mm) {
  Polygon polygon;
  for (const auto& [x, y] : points_mm) polygon.push_back({1e-3 * x, 1e-3 * y});
  return polygon;
}

// The convex body of these corners whose faces are all the planes that have no corner in front; every face is a fan.
inline InputObject Hull(const std::vector<Vec3>& corners) {
  InputObject object;
  object.vertices_base_m = corners;
  const auto n = static_cast<std::uint32_t>(corners.size());
  const auto height = [&](const Vec3& normal, std::uint32_t a, std::uint32_t i) {
    return Dot(normal, corners[i] - corners[a]);
  };
  for (std::uint32_t a = 0; a < n; ++a) {
    for (std::uint32_t b = a + 1; b < n; ++b) {
      for (std::uint32_t c = a + 1; c < n; ++c) {
        if (c == b) continue;
        const Vec3 normal = Normalized(Cross(corners[b] - corners[a], corners[c] - corners[a]));
        bool face = true;  // a is its first corner, b and c follow each other around it
        for (std::uint32_t i = 0; i < n && face; ++i) {
          const double h = height(normal, a, i);
          const bool beside = std::abs(h) < 1e-9 && i != a && i != b && i != c;
          const bool between = beside && Dot(normal, Cross(corners[i] - corners[b], corners[c] - corners[b])) > 1e-15;
          face = h < 1e-9 && !(beside && (i < a || between));
        }
        if (face) AddTriangle(object, a, b, c);
      }
    }
  }
  return object;
}

inline std::vector<Vec3> OctahedronCorners(double r) {
  return {{r, 0, 0}, {-r, 0, 0}, {0, r, 0}, {0, -r, 0}, {0, 0, r}, {0, 0, -r}};
}
inline std::vector<Vec3> IcosahedronCorners(double r) {
  const double a = r / std::sqrt(1 + std::numbers::phi * std::numbers::phi), b = a * std::numbers::phi;
  std::vector<Vec3> corners;
  for (const double s : {-a, a}) {
    for (const double t : {-b, b}) corners.insert(corners.end(), {{0, s, t}, {s, t, 0}, {t, 0, s}});
  }
  return corners;
}

// A radius that depends on the direction.
template <class Radius>
InputObject Radial(int n, Radius&& radius_m) {
  return CubeGrid(n, [&](const Vec3& p) {
    const Vec3 u = Normalized(p);
    return radius_m(u) * u;
  });
}

// A ring of a closed profile in millimetres (distance from the axis, height), counter-clockwise.
inline InputObject Ring(int around, const std::vector<std::array<double, 2>>& profile_mm) {
  const auto n = static_cast<int>(profile_mm.size());
  return Periodic(around, n, [&](double u, double v) {
    const auto& [r, z] = profile_mm[static_cast<std::size_t>(std::lround(v * n / (2 * std::numbers::pi)))];
    return Vec3{1e-3 * r * std::cos(u), 1e-3 * r * std::sin(u), 1e-3 * z};
  });
}

// Turned inside out if its normals point inwards.
inline void Orient(InputObject& object) {
  double six_volumes = 0;
  for (const auto& [a, b, c] : object.triangles) {
    six_volumes += Dot(object.vertices_base_m[a], Cross(object.vertices_base_m[b], object.vertices_base_m[c]));
  }
  for (auto& t : object.triangles) {
    if (six_volumes < 0) std::swap(t[1], t[2]);
  }
}

}  // namespace tip_bodies

inline std::vector<BallBody> TipBodies() {
  using namespace tip_bodies;
  using ball_bodies::Prism, ball_bodies::Spike;
  std::vector<BallBody> bodies = BallBodies();
  const auto add = [&](const char* name, InputObject object) {
    object.name = name;
    bodies.push_back({name, std::move(object)});
  };
  add("octahedron", Hull(OctahedronCorners(0.016)));
  add("icosahedron", Hull(IcosahedronCorners(0.015)));
  add("cylinder", Prism(Regular(48, 0.012), 0.01));
  add("star", Prism(Star(5, 0.007, 0.017), 0.008));
  add("I beam", Prism(Outline({{-12, -14},
                               {12, -14},
                               {12, -10},
                               {2, -10},
                               {2, 10},
                               {12, 10},
                               {12, 14},
                               {-12, 14},
                               {-12, 10},
                               {-2, 10},
                               {-2, -10},
                               {-12, -10}}),
                      0.012));
  add("dovetail", Prism(Outline({{-16, -8}, {16, -8}, {16, 6}, {4, 6}, {8, -2}, {-8, -2}, {-4, 6}, {-16, 6}}), 0.012));
  add("wedge of 8 deg", Prism(Outline({{0, 0}, {36, -2.5}, {36, 2.5}}), 0.014));
  add("sawtooth", Prism(Outline({{-16, -8},
                                 {16, -8},
                                 {16, 2},
                                 {12, 7},
                                 {11.9, 1},
                                 {6, 7},
                                 {5.9, 1},
                                 {0, 7},
                                 {-0.1, 1},
                                 {-6, 7},
                                 {-6.1, 1},
                                 {-12, 7},
                                 {-16, 1}}),
                        0.012));
  add("frame", Ring(4, {{9, -4}, {18, -4}, {18, 4}, {9, 4}}));
  add("tube", Ring(48, {{12, -12}, {14, -12}, {14, 12}, {12, 12}}));
  add("pulley", Ring(40, {{4, -8}, {16, -8}, {9, -1}, {9, 1}, {16, 8}, {4, 8}}));
  add("ring of 1.6 mm", Periodic(64, 10, [](double u, double v) { return TorusPoint(0.015, 0.0008, u, v); }));
  add("needle", Spike(9, 0.0025, 0.03));
  add("burr", Radial(14, [](const Vec3& u) {
        return 0.012 + 0.003 * std::sin(9 * u.x) * std::sin(9 * u.y) * std::sin(9 * u.z);
      }));
  add("dimpled ball", Radial(16, [](const Vec3& u) { return 0.016 - 0.006 * std::exp(-40 * (1 - u.z)); }));
  add("dumbbell", Radial(16, [](const Vec3& u) { return 0.006 + 0.012 * u.z * u.z; }));
  for (BallBody& body : bodies) Orient(body.object);
  return bodies;
}

}  // namespace omni::haptics
