// Bodies with known formulas, and what people's meshes do to them: cracks, bow ties, holes, bodies through each other,
// triangles on their own. The formula stays that of the whole body.
#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "tests/haptics/scenario.h"
#include "tests/support/touch/ball_bodies.h"

namespace omni::haptics::broken {

// Signed distance from the body, m, < 0 inside; inside of a union at least as large as it really is.
using Height = std::function<double(const Vec3&)>;

struct Body {
  std::string name;
  InputObject object;
  Height height;
};

struct Segment {
  Vec3 a, b;
};

// `rims`: of the openings that are so wide that a tip may fall into them. `moved_m`: how far the surface may be from
// the formula's.
struct Broken {
  std::string body, defect;
  InputObject object;
  Height height;
  double moved_m = 0;
  std::vector<Segment> rims;
};

inline double BoxHeight(const Vec3& p, const Vec3& centre, const Vec3& half) {
  const Vec3 d{std::abs(p.x - centre.x) - half.x, std::abs(p.y - centre.y) - half.y, std::abs(p.z - centre.z) - half.z};
  const Vec3 out{std::max(d.x, 0.0), std::max(d.y, 0.0), std::max(d.z, 0.0)};
  return Norm(out) + std::min(std::max({d.x, d.y, d.z}), 0.0);
}

// An icosahedron, its faces cut into four `cuts` times: 20 4^cuts triangles.
inline InputObject Icosphere(int cuts, double radius_m) {
  const double g = (1 + std::sqrt(5.0)) / 2;
  InputObject object;
  object.vertices_base_m = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                            {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<std::uint32_t, 3>> faces = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                                     {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                                     {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                                     {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
  for (int k = 0; k < cuts; ++k) {
    std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
    const auto middle = [&](std::uint32_t a, std::uint32_t b) {
      const auto [at, is_new] = middles.try_emplace(std::minmax(a, b), object.vertices_base_m.size());
      if (is_new) object.vertices_base_m.push_back(object.vertices_base_m[a] + object.vertices_base_m[b]);
      object.vertices_base_m[at->second] = Normalized(object.vertices_base_m[at->second]);
      return at->second;
    };
    for (Vec3& v : object.vertices_base_m) v = Normalized(v);
    std::vector<std::array<std::uint32_t, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const std::uint32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    faces = std::move(finer);
  }
  for (Vec3& v : object.vertices_base_m) v = radius_m * Normalized(v);
  for (const auto& [a, b, c] : faces) AddTriangle(object, a, b, c);
  return object;
}

// Of a convex body: the most outward of its faces' planes. Outside it may be less than the distance.
inline Height PlanesOf(const InputObject& object) {
  std::vector<std::pair<Vec3, double>> planes;
  for (const auto& [a, b, c] : object.triangles) {
    const auto& v = object.vertices_base_m;
    const Vec3 normal = Normalized(Cross(v[b] - v[a], v[c] - v[a]));
    planes.emplace_back(normal, Dot(normal, v[a]));
  }
  return [planes = std::move(planes)](const Vec3& p) {
    double most = -1;
    for (const auto& [normal, offset] : planes) most = std::max(most, Dot(normal, p) - offset);
    return most;
  };
}

inline Body BoxBody() {
  const Vec3 half{0.012, 0.009, 0.007};
  return {"box", Block(8, half), [=](const Vec3& p) { return BoxHeight(p, {}, half); }};
}
inline Body BallBody1280() {
  InputObject ball = Icosphere(3, 0.015);
  Height height = PlanesOf(ball);
  return {"ball of 1280", std::move(ball), std::move(height)};
}
inline Body TorusBody() {
  return {"torus", Periodic(200, 100, [](double u, double v) { return TorusPoint(0.014, 0.006, u, v); }),
          [](const Vec3& p) { return std::hypot(std::hypot(p.x, p.y) - 0.014, p.z) - 0.006; }};
}
inline Body BracketBody() {
  return {"bracket",
          ball_bodies::Prism(
              {{-0.012, -0.012}, {0.012, -0.012}, {0.012, -0.006}, {-0.006, -0.006}, {-0.006, 0.012}, {-0.012, 0.012}},
              0.01),
          [](const Vec3& p) {
            return std::min(BoxHeight(p, {0, -0.009, 0}, {0.012, 0.003, 0.01}),
                            BoxHeight(p, {-0.009, 0, 0}, {0.003, 0.012, 0.01}));
          }};
}

inline Vec3 Corner(const InputObject& object, std::size_t t, std::size_t k) {
  return object.vertices_base_m[object.triangles[t][k]];
}

// Each triangle with corners of its own, placed by place(triangle, corner).
template <class Place>
InputObject Separate(const InputObject& object, Place&& place) {
  InputObject apart;
  for (std::size_t t = 0; t < object.triangles.size(); ++t) {
    const auto first = static_cast<std::uint32_t>(apart.vertices_base_m.size());
    for (std::size_t k = 0; k < 3; ++k) apart.vertices_base_m.push_back(place(t, k));
    AddTriangle(apart, first, first + 1, first + 2);
  }
  return apart;
}

// In its plane, each edge moved inwards by d (outwards where it is < 0).
inline Vec3 Inset(const InputObject& object, std::size_t t, std::size_t k, double d) {
  const Vec3 p = Corner(object, t, k);
  const Vec3 u = Normalized(Corner(object, t, (k + 1) % 3) - p), w = Normalized(Corner(object, t, (k + 2) % 3) - p);
  return p + (d / Norm(Cross(u, w))) * (u + w);
}

inline std::string Length(double m) {
  char text[32];
  std::snprintf(text, sizeof text, "%.0e m", m);
  return text;
}

// Every corner of every triangle is somewhere else within w / 2, as after coarse rounding.
inline Broken Jittered(const Body& body, double w, std::uint64_t seed) {
  Random random(seed);
  return {body.name,
          "cracks everywhere, " + Length(w),
          Separate(body.object,
                   [&](std::size_t t, std::size_t k) {
                     return Corner(body.object, t, k) + random.Uniform(0, 0.5 * w) * Normalized(random.InBox(1));
                   }),
          body.height,
          0.5 * w,
          {}};
}

// A net of cracks of one width between all triangles.
inline Broken Shrunk(const Body& body, double w) {
  return {body.name,
          "a crack along every edge, " + Length(w),
          Separate(body.object, [&](std::size_t t, std::size_t k) { return Inset(body.object, t, k, 0.5 * w); }),
          body.height,
          0,
          {}};
}

// Triangles that overlap their neighbours in all ways and are joined to none.
inline Broken Soup(const Body& body, std::uint64_t seed) {
  Random random(seed);
  InputObject soup = Separate(body.object, [&](std::size_t t, std::size_t k) {
    return Inset(body.object, t, k, random.Uniform(-8e-6, -2e-6)) + random.InBox(4e-6);
  });
  for (std::size_t t = soup.triangles.size(); t > 1; --t)
    std::swap(soup.triangles[t - 1], soup.triangles[random.Next() % t]);
  return {body.name, "soup", std::move(soup), body.height, 2.5e-5, {}};
}

// Cut in two along the edges nearest to a plane through the middle; the halves are w apart. Over 50 um it is an
// opening.
inline Broken Parted(const Body& body, double w, std::uint64_t seed) {
  Random random(seed);
  const Vec3 n = Normalized(random.InBox(1));
  const InputObject& whole = body.object;
  const auto upper = [&](std::size_t t) {
    return Dot(n, Corner(whole, t, 0) + Corner(whole, t, 1) + Corner(whole, t, 2)) > 0;
  };
  InputObject parted;
  std::map<std::pair<std::uint32_t, std::uint32_t>, int> sides;
  for (const double side : {1.0, -1.0}) {
    const auto first = static_cast<std::uint32_t>(parted.vertices_base_m.size());
    for (const Vec3& v : whole.vertices_base_m) parted.vertices_base_m.push_back(v + (0.5 * side * w) * n);
    for (std::size_t t = 0; t < whole.triangles.size(); ++t) {
      if (upper(t) != (side > 0)) continue;
      const auto& v = whole.triangles[t];
      AddTriangle(parted, first + v[0], first + v[1], first + v[2]);
      for (std::size_t k = 0; k < 3; ++k) sides[std::minmax(v[k], v[(k + 1) % 3])] |= side > 0 ? 1 : 2;
    }
  }
  Broken broken{body.name, "in two halves, " + Length(w) + " apart", std::move(parted), body.height, 0.5 * w, {}};
  if (w <= 5e-5) return broken;
  broken.moved_m = 0;
  broken.height = [whole_height = body.height, n, w](const Vec3& p) {
    return whole_height(p - (0.5 * w * (Dot(n, p) > 0 ? 1 : -1)) * n);
  };
  for (const auto& [edge, in] : sides) {
    const Vec3 a = whole.vertices_base_m[edge.first], b = whole.vertices_base_m[edge.second];
    if (in == 3) broken.rims.push_back({a, b});
  }
  return broken;
}

// Pairs of triangles around a vertex are missing, which have only this vertex in common.
inline Broken HolesInPairs(const Body& body, int pairs, std::uint64_t seed) {
  Random random(seed);
  std::vector<std::vector<std::size_t>> around(body.object.vertices_base_m.size());
  for (std::size_t t = 0; t < body.object.triangles.size(); ++t) {
    for (const std::uint32_t v : body.object.triangles[t]) around[v].push_back(t);
  }
  std::vector<bool> gone(body.object.triangles.size(), false), closed_to(body.object.vertices_base_m.size(), false);
  for (int k = 0; k < 1000 && pairs > 0; ++k) {
    const auto v = static_cast<std::uint32_t>(random.Next() % around.size());
    std::vector<std::size_t> fan = around[v];
    const auto joined = [&](std::size_t a, std::size_t b) {
      int shared = 0;
      for (const std::uint32_t i : body.object.triangles[a]) {
        for (const std::uint32_t j : body.object.triangles[b]) shared += i == j;
      }
      return shared > 1;
    };
    if (fan.size() < 5) continue;
    const std::size_t first = fan[random.Next() % fan.size()];
    const auto other =
        std::find_if(fan.begin(), fan.end(), [&](std::size_t t) { return t != first && !joined(t, first); });
    const auto is_near_gap = [&](std::size_t t) {
      return std::any_of(body.object.triangles[t].begin(), body.object.triangles[t].end(),
                         [&](std::uint32_t i) { return closed_to[i]; });
    };
    if (other == fan.end() || is_near_gap(first) || is_near_gap(*other)) continue;
    for (const std::size_t t : {first, *other}) {
      gone[t] = true;
      for (const std::uint32_t i : body.object.triangles[t]) closed_to[i] = true;
    }
    --pairs;
  }
  Broken broken{body.name, "holes that share a vertex", body.object, body.height, 0, {}};
  broken.object.triangles.clear();
  broken.object.triangle_material.clear();
  for (std::size_t t = 0; t < gone.size(); ++t) {
    const auto& [a, b, c] = body.object.triangles[t];
    if (!gone[t]) AddTriangle(broken.object, a, b, c);
  }
  return broken;
}

// The body and its mirror image through its vertex 0, which both have.
inline Broken BowTie(const Body& body) {
  const Vec3 tie = body.object.vertices_base_m[0];
  Broken broken{body.name, "two bodies at one vertex", body.object, {}, 0, {}};
  const auto n = static_cast<std::uint32_t>(body.object.vertices_base_m.size());
  for (const Vec3& v : body.object.vertices_base_m) broken.object.vertices_base_m.push_back(2 * tie - v);
  const auto other = [&](std::uint32_t v) { return v == 0 ? 0 : n + v; };
  for (const auto& [a, b, c] : body.object.triangles) AddTriangle(broken.object, other(a), other(c), other(b));
  broken.height = [height = body.height, tie](const Vec3& p) { return std::min(height(p), height(2 * tie - p)); };
  return broken;
}

// The body and the same one moved by `by`, in one object. `turned`: that one is inside-out.
inline Broken Crossing(const Body& body, const Vec3& by, bool turned) {
  Broken broken{body.name, turned ? "through each other, one inside-out" : "through each other", body.object, {}, 0,
                {}};
  const auto n = static_cast<std::uint32_t>(body.object.vertices_base_m.size());
  for (const Vec3& v : body.object.vertices_base_m) broken.object.vertices_base_m.push_back(v + by);
  for (const auto& [a, b, c] : body.object.triangles)
    AddTriangle(broken.object, n + a, n + (turned ? c : b), n + (turned ? b : c));
  broken.height = [height = body.height, by](const Vec3& p) { return std::min(height(p), height(p - by)); };
  return broken;
}

// All bodies and defects. `quick`: one of a kind.
inline std::vector<Broken> BrokenBodies(std::uint64_t seed, bool quick) {
  std::vector<Body> bodies{BallBody1280(), BoxBody(), BracketBody()};
  if (!quick) bodies.push_back(TorusBody());
  std::vector<Broken> all;
  for (const Body& body : bodies) {
    all.push_back({body.name, "none", body.object, body.height, 0, {}});
    for (const double w : quick ? std::vector{7e-9, 5e-6} : std::vector{1e-8, 1e-7, 1e-6, 5e-6, 1e-5})
      all.push_back(Jittered(body, w, seed));
    for (const double w : quick ? std::vector{5e-5} : std::vector{1e-8, 1e-7, 1e-6, 1e-5, 5e-5})
      all.push_back(Shrunk(body, w));
    for (const double w : quick ? std::vector{2e-5, 1e-3} : std::vector{1e-7, 1e-6, 1e-5, 5e-5, 2e-4, 1e-3})
      if (w <= 5e-5 || body.name != "bracket") all.push_back(Parted(body, w, seed));  // it has no edges near a plane
    all.push_back(Soup(body, seed));
    if (body.name != "bracket") all.push_back(HolesInPairs(body, 12, seed));
    all.push_back(BowTie(body));
    all.push_back(Crossing(body, {0.007, 0.003, 0.002}, false));
    all.push_back(Crossing(body, {0.007, 0.003, 0.002}, true));
  }
  // Several at once: crossing bodies of which no two triangles are joined.
  Body crossing = BallBody1280();
  const Broken both = Crossing(crossing, {0.007, 0.003, 0.002}, false);
  all.push_back(Soup({"two balls of 1280 through each other", both.object, both.height}, seed));
  all.push_back(Shrunk({"two balls of 1280 through each other", both.object, both.height}, 5e-5));
  return all;
}

}  // namespace omni::haptics::broken
