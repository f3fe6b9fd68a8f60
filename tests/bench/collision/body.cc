#include "tests/bench/collision/body.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <unordered_map>

#include "tests/haptics/scenario.h"

namespace omni::collision {
namespace {

double InFloat(double x) { return static_cast<double>(static_cast<float>(x)); }

// Welds vertices at equal places (in float), drops triangles that lose a corner by it.
void Weld(Body& body) {
  struct Hash {
    std::size_t operator()(const std::array<float, 3>& p) const {
      std::size_t h = 0;
      for (const float x : p) h = h * 1000003 + std::hash<float>()(x);
      return h;
    }
  };
  std::unordered_map<std::array<float, 3>, std::uint32_t, Hash> places;
  places.reserve(body.vertices.size());
  std::vector<std::uint32_t> map;
  std::vector<Vec3> kept;
  for (const Vec3& v : body.vertices) {
    const std::array<float, 3> place{static_cast<float>(v.x) + 0.0F, static_cast<float>(v.y) + 0.0F,
                                     static_cast<float>(v.z) + 0.0F};
    const auto [at, added] = places.try_emplace(place, static_cast<std::uint32_t>(kept.size()));
    if (added) kept.push_back({InFloat(v.x), InFloat(v.y), InFloat(v.z)});
    map.push_back(at->second);
  }
  body.vertices = std::move(kept);
  for (auto& t : body.triangles) {
    for (std::uint32_t& v : t) v = map[v];
  }
  std::erase_if(body.triangles, [](const auto& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; });
}

Body FromObject(haptics::InputObject object, std::string name, bool smooth) {
  Body body;
  body.name = std::move(name);
  body.smooth = smooth;
  body.vertices = std::move(object.vertices_base_m);
  body.triangles = std::move(object.triangles);
  Weld(body);
  Connect(body);
  return body;
}

struct Wave {
  Vec3 frequency;
  double phase, height;
};

}  // namespace

Body MakeLump(std::uint32_t triangles, std::uint64_t seed) {
  constexpr double kRadius_m = 0.04;
  const int n = static_cast<int>(std::lround(std::sqrt(triangles / 12.0)));
  const double edge_rad = std::numbers::pi / 2 / n;
  haptics::Random random(seed);
  std::vector<Wave> waves;
  for (double frequency = 2.2; frequency < 2 * std::numbers::pi / (4 * edge_rad); frequency *= 1.7) {
    for (int k = 0; k < 3; ++k) {
      const Vec3 direction = Normalized(random.InBox(1));
      const double height = 0.12 / std::pow(frequency, 1.6);  // gentle: the least radius of curvature is some mm
      waves.push_back({frequency * direction, random.Uniform(0, 2 * std::numbers::pi), height});
    }
  }
  return FromObject(
      haptics::CubeGrid(n,
                        [&](const Vec3& p) {
                          const double q = std::numbers::pi / 4;  // even squares, as on a sphere
                          const Vec3 d = base::Normalized({std::tan(q * p.x), std::tan(q * p.y), std::tan(q * p.z)});
                          double r = 1;
                          for (const Wave& w : waves) {
                            r += w.height * std::sin(Dot(w.frequency, d) + w.phase);
                          }
                          return kRadius_m * r * d;
                        }),
      "lump", true);
}

Body MakeGear(std::uint32_t triangles) {
  constexpr int kTeeth = 12, kAround = 4 * kTeeth, kProfile = 8;
  // r, z in m, counter-clockwise: a step inside, a groove on top.
  constexpr std::array<std::array<double, 2>, kProfile> profile = {{{0.018, -0.010},
                                                                    {0.034, -0.010},
                                                                    {0.034, 0.010},
                                                                    {0.028, 0.010},
                                                                    {0.026, 0.006},
                                                                    {0.024, 0.010},
                                                                    {0.018, 0.010},
                                                                    {0.015, 0.0}}};
  const double pieces = std::sqrt(triangles / 2.0 / (kAround * kProfile));  // per side of a tooth and of the profile
  const int pu = std::max(1, static_cast<int>(std::lround(pieces * 0.8)));
  const int pv = std::max(1, static_cast<int>(std::lround(triangles / 2.0 / (kAround * kProfile) / pu)));
  const auto tooth = [](double u) {  // 0 or 1 on the flats, between them steep
    const double x = u * kAround / (2 * std::numbers::pi), part = x - 4 * std::floor(x / 4);
    return part < 1 ? part : (part < 2 ? 1 : (part < 3 ? 3 - part : 0));
  };
  return FromObject(haptics::Periodic(kAround * pu, kProfile * pv,
                                      [&](double u, double v) {
                                        const double y = v * kProfile / (2 * std::numbers::pi);
                                        const auto k = static_cast<std::size_t>(std::floor(y + 1e-9)) % kProfile;
                                        const double s = std::max(0.0, y - std::floor(y + 1e-9));
                                        const auto& a = profile[k];
                                        const auto& b = profile[(k + 1) % kProfile];
                                        const double r0 = a[0] + s * (b[0] - a[0]), z = a[1] + s * (b[1] - a[1]);
                                        const double r = r0 + (r0 > 0.03 ? 0.006 * tooth(u) * (r0 - 0.03) / 0.004 : 0);
                                        return Vec3{r * std::cos(u), r * std::sin(u), z};
                                      }),
                    "gear", false);
}

base::Result<Body> ReadGlb(const std::string& path) {
  auto object = ReadGlbObject(path);
  if (!object.ok()) return base::Error{object.error()};
  const std::size_t slash = path.find_last_of('/');
  return FromObject(std::move(*object), path.substr(slash == std::string::npos ? 0 : slash + 1), false);
}

void Connect(Body& body) {
  const std::size_t n = body.triangles.size();
  struct Edge {
    std::uint64_t key;
    std::uint32_t triangle, edge;
  };
  std::vector<Edge> edges;
  edges.reserve(3 * n);
  body.normals.assign(body.vertices.size(), {});
  for (std::uint32_t t = 0; t < n; ++t) {
    const auto& v = body.triangles[t];
    const Vec3 normal =
        Normalized(Cross(body.vertices[v[1]] - body.vertices[v[0]], body.vertices[v[2]] - body.vertices[v[0]]));
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t a = v[k], b = v[(k + 1) % 3], c = v[(k + 2) % 3];
      edges.push_back({std::uint64_t{std::min(a, b)} << 32 | std::max(a, b), t, k});
      const Vec3 e1 = body.vertices[b] - body.vertices[a], e2 = body.vertices[c] - body.vertices[a];
      body.normals[a] = body.normals[a] + std::atan2(Norm(Cross(e1, e2)), Dot(e1, e2)) * normal;
    }
  }
  for (Vec3& normal : body.normals) normal = Normalized(normal);
  std::sort(edges.begin(), edges.end(), [](const Edge& x, const Edge& y) { return x.key < y.key; });
  body.neighbours.assign(n, {haptics::kNoIndex, haptics::kNoIndex, haptics::kNoIndex});
  body.closed = true;
  for (std::size_t i = 0; i < edges.size();) {
    std::size_t end = i + 1;
    while (end < edges.size() && edges[end].key == edges[i].key) ++end;
    if (end - i == 2) {
      body.neighbours[edges[i].triangle][edges[i].edge] = edges[i + 1].triangle;
      body.neighbours[edges[i + 1].triangle][edges[i + 1].edge] = edges[i].triangle;
    } else {
      body.closed = false;
    }
    i = end;
  }
}

}  // namespace omni::collision
