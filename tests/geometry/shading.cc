// Shaded normals on bodies whose true normal is known, at creases and on flat faces; what a closed path gains.
#include <gtest/gtest.h>

#include "service/haptics/contact/proxy.h"
#include "service/haptics/contact/shading.h"
#include "service/haptics/scene/scene.h"
#include "tests/haptics/oracle.h"
#include "tests/support/surface_queries.h"

namespace omni::haptics {
namespace test_geometry_shading {

constexpr double kDegree = std::numbers::pi / 180;

// A ball by dividing an icosahedron's triangles `times` times in four, stretched along the axes by `half_m`.
InputObject Icosphere(int times, const Vec3& half_m) {
  const double g = std::numbers::phi;
  std::vector<Vec3> corners = {{-1, g, 0},  {1, g, 0},  {-1, -g, 0}, {1, -g, 0}, {0, -1, g},  {0, 1, g},
                               {0, -1, -g}, {0, 1, -g}, {g, 0, -1},  {g, 0, 1},  {-g, 0, -1}, {-g, 0, 1}};
  std::vector<std::array<Vec3, 3>> facets;
  constexpr std::array<std::array<std::size_t, 3>, 20> kFacets = {
      {{0, 11, 5},  {0, 5, 1},  {0, 1, 7},  {0, 7, 10}, {0, 10, 11}, {1, 5, 9}, {5, 11, 4},
       {11, 10, 2}, {10, 7, 6}, {7, 1, 8},  {3, 9, 4},  {3, 4, 2},   {3, 2, 6}, {3, 6, 8},
       {3, 8, 9},   {4, 9, 5},  {2, 4, 11}, {6, 2, 10}, {8, 6, 7},   {9, 8, 1}}};
  for (const auto& f : kFacets) facets.push_back({corners[f[0]], corners[f[1]], corners[f[2]]});
  for (int k = 0; k < times; ++k) {
    std::vector<std::array<Vec3, 3>> finer;
    for (const auto& [a, b, c] : facets) {
      const Vec3 ab = Normalized(a + b), bc = Normalized(b + c), ca = Normalized(c + a);
      finer.insert(finer.end(), {{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}});
    }
    facets = finer;
    for (auto& f : facets) f = {Normalized(f[0]), Normalized(f[1]), Normalized(f[2])};
  }
  InputObject object;
  object.name = "icosphere";
  for (const auto& f : facets) {
    const auto base = static_cast<std::uint32_t>(object.vertices_base_m.size());
    for (const Vec3& v : f) {
      const Vec3 d = Normalized(v);
      object.vertices_base_m.push_back({half_m.x * d.x, half_m.y * d.y, half_m.z * d.z});
    }
    AddTriangle(object, base, base + 1, base + 2);
  }
  return object;
}

std::array<double, 3> RandomWeights(Random& random) {
  const double a = random.Uniform(0, 1), b = random.Uniform(0, 1);
  return a + b < 1 ? std::array{a, b, 1 - a - b} : std::array{1 - a, 1 - b, a + b - 1};
}

Vec3 At(const Corners& c, const std::array<double, 3>& w) { return w[0] * c[0] + w[1] * c[1] + w[2] * c[2]; }

double Angle(const Vec3& a, const Vec3& b) { return std::atan2(Norm(Cross(a, b)), Dot(a, b)); }

// Of an ellipsoid, through a point near its surface.
Vec3 NormalOf(const Vec3& half_m, const Vec3& p) {
  return base::Normalized({p.x / (half_m.x * half_m.x), p.y / (half_m.y * half_m.y), p.z / (half_m.z * half_m.z)});
}

struct Miss {
  double facet_worst = 0, shaded_worst = 0, facet_sum = 0, shaded_sum = 0;
};

// By how much the true normal is missed, in radians; checks that no direction is further from its facet than facets
// around it are.
Miss MissOn(const Vec3& half_m, int times, Random& random) {
  const Scene scene = Built(SceneOf(Icosphere(times, half_m)));
  const Surface surface(scene, {});
  Miss miss;
  for (int k = 0; k < 5000; ++k) {
    const auto t = static_cast<std::uint32_t>(random.Next() % scene.header().triangle_count);
    const auto weights = RandomWeights(random);
    const Vec3 truth = NormalOf(half_m, At(surface.TriangleCorners(t), weights));
    const Vec3 facet = FaceNormal(surface, t), shaded = ShadedNormal(surface, t, weights);
    EXPECT_NEAR(Norm(shaded), 1, 1e-12);
    miss.facet_worst = std::max(miss.facet_worst, Angle(facet, truth));
    miss.shaded_worst = std::max(miss.shaded_worst, Angle(shaded, truth));
    miss.facet_sum += Angle(facet, truth);
    miss.shaded_sum += Angle(shaded, truth);
    double around = 0;
    for (int corner = 0; corner < 3; ++corner) {
      WalkRing(surface, t, surface.GetTriangle(t).vertex[corner],
               [&](std::uint32_t fan, int) { around = std::max(around, Angle(FaceNormal(surface, fan), facet)); });
    }
    EXPECT_LE(Angle(shaded, facet), around + 1e-9);
  }
  return miss;
}

// On a ball the shaded normal is the true one, on an ellipsoid it is nearer by a factor that grows as the mesh gets
// finer.
TEST(Shading, ShadedNormalIsCloserToTheTrueNormal) {
  Random random(1301);
  for (const int times : {1, 2, 3, 4}) {
    const Miss ball = MissOn({0.02, 0.02, 0.02}, times, random);
    EXPECT_LT(ball.shaded_worst, 1e-9) << times;
    EXPECT_GT(ball.facet_worst, 1e-2) << times;
    const Miss egg = MissOn({0.02, 0.016, 0.014}, times, random);
    RecordProperty("worst_ratio_" + std::to_string(times), std::to_string(egg.facet_worst / egg.shaded_worst));
    RecordProperty("mean_ratio_" + std::to_string(times), std::to_string(egg.facet_sum / egg.shaded_sum));
    EXPECT_LT(egg.shaded_worst, egg.facet_worst / (times + 1)) << times;
    EXPECT_LT(egg.shaded_sum, egg.facet_sum / (2 * times + 1)) << times;
  }
}

// From one facet to the next the direction does not jump: on their common edge both say the same.
TEST(Shading, IsContinuousOverSmoothEdges) {
  Random random(1302);
  const Scene scene =
      Built(SceneOf(Periodic(24, 14, [](double u, double v) { return TorusPoint(0.02, 0.007, u, v); })));
  const Surface surface(scene, {});
  for (int k = 0; k < 3000; ++k) {
    const auto t = static_cast<std::uint32_t>(random.Next() % scene.header().triangle_count);
    const auto& triangle = surface.GetTriangle(t);
    const auto edge = static_cast<std::size_t>(random.Next() % 3);
    const std::uint32_t other = triangle.neighbour[edge];
    const double s = random.Uniform(0.01, 0.99);
    std::array<double, 3> here{}, there{};
    here[edge] = 1 - s;
    here[(edge + 1) % 3] = s;
    there[static_cast<std::size_t>(CornerOf(surface.GetTriangle(other), triangle.vertex[edge]))] = 1 - s;
    there[static_cast<std::size_t>(CornerOf(surface.GetTriangle(other), triangle.vertex[(edge + 1) % 3]))] = s;
    ASSERT_LT(Norm(ShadedNormal(surface, t, here) - ShadedNormal(surface, other, there)), 1e-9) << k;
  }
}

// A block's faces and edges, however finely cut, are as without shading, bit by bit; so are the walls of a prism whose
// sides meet at 36 degrees, while at 30 degrees they are round.
TEST(Shading, LeavesFlatFacesAndSharpEdgesAlone) {
  Random random(1303);
  for (const int n : {1, 9}) {
    const Scene scene = Built(SceneOf(Block(n, {0.02, 0.013, 0.007})));
    const Surface surface(scene, {});
    for (int k = 0; k < 3000; ++k) {
      const auto t = static_cast<std::uint32_t>(random.Next() % scene.header().triangle_count);
      ASSERT_EQ(ShadedNormal(surface, t, RandomWeights(random)), FaceNormal(surface, t));
      const Vec3 tip = At(surface.TriangleCorners(t), RandomWeights(random)) + random.InBox(4e-3);
      const ProxyPoint proxy = DescendOnSurface(surface, t, tip);
      const Vec3 direction = Normalized(proxy.closest.point - tip);
      ASSERT_EQ(ShadedDirection(surface, proxy.triangle, proxy.closest, direction), direction);
    }
  }
  for (const int sides : {10, 12}) {
    InputObject prism;
    prism.name = "prism";
    prism.double_sided = true;
    const auto at = [&](int k, int level) { return static_cast<std::uint32_t>(2 * (k % sides) + level); };
    for (int k = 0; k < sides; ++k) {
      const double a = 2 * std::numbers::pi * k / sides;
      for (const double z : {-0.01, 0.01}) prism.vertices_base_m.push_back({0.02 * std::cos(a), 0.02 * std::sin(a), z});
    }
    for (int k = 0; k < sides; ++k) {
      AddTriangle(prism, at(k, 0), at(k + 1, 0), at(k + 1, 1));
      AddTriangle(prism, at(k, 0), at(k + 1, 1), at(k, 1));
    }
    const Scene built = Built(SceneOf(prism));
    const Surface surface(built, {});
    bool turned = false;
    for (std::uint32_t t = 0; t < built.header().triangle_count; ++t) {
      const Vec3 facet = FaceNormal(surface, t), shaded = ShadedNormal(surface, t, {0.8, 0.1, 0.1});
      turned = turned || !(shaded == facet);
      ASSERT_LT(Angle(shaded, facet), 15.01 * kDegree);
    }
    EXPECT_EQ(turned, sides == 12);
  }
}

// Work of the force on a tip that is led around a closed path at constant depth, in units of the energy K d^2 / 2 that
// the contact holds. Shading turns the force out of the spring's direction, so it is not zero; it stays a small share.
TEST(Shading, EnergyGainedOnClosedPathsIsSmall) {
  Random random(1304);
  const Scene scene = Built(SceneOf(Icosphere(2, {0.02, 0.02, 0.02})));
  const Surface surface(scene, {});
  double worst_shaded = 0, worst_plain = 0;
  for (int path = 0; path < 40; ++path) {
    const Vec3 axis = Normalized(random.InBox(1)), u = Normalized(Cross(axis, random.InBox(1))), v = Cross(axis, u);
    const double cone = random.Uniform(0.1, 1.2), depth_m = random.Uniform(5e-4, 2e-3);
    constexpr int kSteps = 4000;
    const auto tip_at = [&](int k) {
      const double a = 2 * std::numbers::pi * k / kSteps;
      const Vec3 d = std::cos(cone) * axis + std::sin(cone) * (std::cos(a) * u + std::sin(a) * v);
      return (0.0195 - depth_m) * d;
    };
    std::uint32_t triangle = support::NearestPoint(surface, scene.objects()[0], tip_at(0)).triangle;
    double plain_J = 0, shaded_J = 0;  // for K = 1 N/m
    for (int k = 0; k < 2 * kSteps; ++k) {
      const Vec3 tip = tip_at(k), step = tip_at(k + 1) - tip;
      const ProxyPoint proxy = DescendOnSurface(surface, triangle, tip);
      triangle = proxy.triangle;
      if (k < kSteps) continue;  // the first round finds the path
      const double now_m = std::sqrt(proxy.closest.distance_squared);
      const Vec3 direction = (1 / now_m) * (proxy.closest.point - tip);
      plain_J += now_m * Dot(direction, step);
      shaded_J += now_m * Dot(ShadedDirection(surface, triangle, proxy.closest, direction), step);
    }
    const double held_J = 0.5 * (depth_m + 5e-4) * (depth_m + 5e-4);
    worst_plain = std::max(worst_plain, std::abs(plain_J) / held_J);
    worst_shaded = std::max(worst_shaded, std::abs(shaded_J) / held_J);
  }
  RecordProperty("worst_plain_share", std::to_string(worst_plain));
  RecordProperty("worst_shaded_share", std::to_string(worst_shaded));
  EXPECT_LT(worst_shaded, 0.5) << "plain " << worst_plain;
}

}  // namespace test_geometry_shading
}  // namespace omni::haptics
