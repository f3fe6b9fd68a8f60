// Tree queries match brute force; the sign matches the winding number.
#include <gtest/gtest.h>

#include <set>

#include "service/haptics/geometry/query.h"
#include "service/haptics/geometry/topology.h"
#include "service/haptics/scene/scene.h"
#include "tests/haptics/oracle.h"
#include "tests/support/surface_queries.h"

namespace omni::haptics {
namespace test_geometry_queries {

struct Shape {
  const char* name;
  InputObject object;
};

std::vector<Shape> Shapes() {
  return {{"sphere", Sphere(8, 0.02)},
          {"block", Block(5, {0.02, 0.01, 0.015})},
          {"torus", Periodic(40, 20, [](double u, double v) { return TorusPoint(0.02, 0.007, u, v); })},
          {"ridges", Periodic(120, 10, [](double u, double v) {
             return TorusPoint(0.02, 0.006 + 0.001 * std::cos(20 * u), u, v);
           })}};
}

TEST(Queries, NearestPointMatchesBruteForce) {
  Random random(101);
  for (const Shape& shape : Shapes()) {
    const Scene scene = Built(SceneOf(shape.object));
    const Surface surface(scene, {});
    for (int k = 0; k < 400; ++k) {
      const Vec3 p = random.InBox(k % 4 == 0 ? 0.2 : 0.03);
      const NearestResult fast = support::NearestPoint(surface, scene.objects()[0], p);
      const NearestResult brute = BruteNearest(scene, surface, p);
      ASSERT_EQ(fast.closest.distance_squared, brute.closest.distance_squared) << shape.name;
      const double within = 1.0001 * std::sqrt(brute.closest.distance_squared);
      ASSERT_EQ(support::NearestPoint(surface, scene.objects()[0], p, within).closest.distance_squared,
                brute.closest.distance_squared);
      ASSERT_EQ(
          support::NearestPoint(surface, scene.objects()[0], p, 0.9999 * std::sqrt(brute.closest.distance_squared))
              .triangle,
          kNoIndex);
    }
  }
}

TEST(Queries, FirstCrossingMatchesBruteForce) {
  Random random(102);
  int hits = 0;
  for (const Shape& shape : Shapes()) {
    const Scene scene = Built(SceneOf(shape.object));
    const Surface surface(scene, {});
    for (int k = 0; k < 1000; ++k) {
      const Vec3 a = random.InBox(0.03);
      const Vec3 b = k % 2 == 0 ? random.InBox(0.03) : a + random.InBox(0.002);
      CrossingResult brute;
      brute.t = 2;
      for (std::uint32_t t = 0; t < scene.header().triangle_count; ++t) {
        const TriangleHit hit = IntersectTriangle(surface.TriangleCorners(t), a, b);
        if (hit.hit && hit.front && hit.t < brute.t) brute = {t, true, hit.t};
      }
      const CrossingResult fast = support::FirstCrossing(surface, scene.objects()[0], a, b);
      ASSERT_EQ(fast.t, brute.t) << shape.name;
      hits += fast.triangle != kNoIndex;
    }
  }
  EXPECT_GT(hits, 500);
}

TEST(Queries, SignMatchesTheWindingNumber) {
  Random random(103);
  int inside = 0;
  for (const Shape& shape : Shapes()) {
    const Scene scene = Built(SceneOf(shape.object));
    const Surface surface(scene, {});
    for (int k = 0; k < 300; ++k) {
      const Vec3 p = random.InBox(0.025);
      const bool by_sign = SideOf(surface, support::NearestPoint(surface, scene.objects()[0], p), p) < 0;
      ASSERT_EQ(by_sign, WindingNumber(scene, surface, p) > 0.5) << shape.name;
      inside += by_sign;
    }
  }
  EXPECT_GT(inside, 100);
}

// At a corner of a block the three sides count alike, however finely one of them is cut (angle weights).
TEST(Queries, PseudonormalOfACornerDoesNotDependOnTriangles) {
  InputObject block = Block(1, {0.02, 0.02, 0.02});
  const Vec3 corner{0.02, 0.02, 0.02};
  block.vertices_base_m.push_back({0.02, 0.019, 0.015});  // splits one triangle at the corner in three
  const auto extra = static_cast<std::uint32_t>(block.vertices_base_m.size() - 1);
  for (std::size_t t = 0; t < block.triangles.size(); ++t) {
    const auto [a, b, c] = block.triangles[t];
    const auto& v = block.vertices_base_m;
    const bool on_side = v[a].x == 0.02 && v[b].x == 0.02 && v[c].x == 0.02;
    if (!on_side || (v[a] != corner && v[b] != corner && v[c] != corner)) continue;
    const Vec3 p = v[extra];
    const Vec3 n = Cross(v[b] - v[a], v[c] - v[a]);
    const bool holds = Dot(Cross(v[b] - v[a], p - v[a]), n) > 0 && Dot(Cross(v[c] - v[b], p - v[b]), n) > 0 &&
                       Dot(Cross(v[a] - v[c], p - v[c]), n) > 0;
    if (!holds) continue;
    block.triangles[t] = {a, b, extra};
    AddTriangle(block, b, c, extra);
    AddTriangle(block, c, a, extra);
    break;
  }
  ASSERT_EQ(block.triangles.size(), 14U);
  const Scene scene = Built(SceneOf(block));
  const Surface surface(scene, {});
  const NearestResult nearest = support::NearestPoint(surface, scene.objects()[0], {0.03, 0.03, 0.03});
  ASSERT_EQ(nearest.closest.feature, Feature::kVertex);
  const Vec3 normal = Pseudonormal(surface, nearest.triangle, nearest.closest.feature, nearest.closest.index);
  EXPECT_LT(Norm(normal - base::Normalized({1, 1, 1})), 1e-12);
}

// Lines through vertices and edges of a closed mesh never slip through between two triangles.
TEST(Queries, SegmentsThroughEdgesAndVerticesHit) {
  const Scene scene = Built(SceneOf(Sphere(8, 0.02)));
  const Surface surface(scene, {});
  Random random(104);
  for (int k = 0; k < 3000; ++k) {
    const auto t = static_cast<std::uint32_t>(random.Next() % scene.header().triangle_count);
    const Corners c = surface.TriangleCorners(t);
    const Vec3 on_edge = k % 3 == 0 ? c[0] : c[0] + random.Uniform(0, 1) * (c[1] - c[0]);
    const Vec3 outside = 2.0 * on_edge + random.InBox(0.005);
    const Vec3 inside = on_edge + 0.4 * (on_edge - outside);
    ASSERT_NE(support::FirstCrossing(surface, scene.objects()[0], outside, inside).triangle, kNoIndex) << k;
  }
}

bool Holds(const TreeNode& node, int k, const Vec3& v) {
  return node.lower[0][k] <= v.x && v.x <= node.upper[0][k] && node.lower[1][k] <= v.y && v.y <= node.upper[1][k] &&
         node.lower[2][k] <= v.z && v.z <= node.upper[2][k];
}

TEST(Queries, TreeBoxesHoldTrianglesAtEveryExtrudeOffset) {
  Material clay;
  clay.extrude.enabled = true;
  InputObject fan;  // needles of very different sizes
  fan.vertices_base_m.push_back({});
  for (int k = 0; k < 3000; ++k) {
    const double r = 1e-6 * std::pow(1.004, k);
    fan.vertices_base_m.push_back({r * std::cos(k), r * std::sin(k), 0.1 * r});
  }
  for (std::uint32_t k = 1; k < 3000; ++k) AddTriangle(fan, 0, k, k + 1);
  SceneInput input = SceneOf(Block(10, {0.02, 0.02, 0.02}), clay);
  input.objects.push_back(fan);
  const Scene scene = Built(input);
  ASSERT_FALSE(scene.empty());
  std::array<RegionState, kMaxRegions> states{};
  for (const double sign : {-1.0, 0.0, 1.0}) {
    for (RegionState& s : states) s.offset_m = sign * clay.extrude.step_m;
    const Surface surface(scene, states);
    for (const Object& object : scene.objects()) {
      std::vector<std::pair<std::uint32_t, int>> stack{{object.root, 1}};
      std::set<std::uint32_t> seen;
      while (!stack.empty()) {
        const auto [index, depth] = stack.back();
        stack.pop_back();
        ASSERT_LE(depth, kMaxTreeDepth);
        const TreeNode& node = surface.Node(index);
        for (int k = 0; k < kTreeWidth; ++k) {
          if (node.child[k] == kNoChild) continue;
          if ((node.child[k] & kLeafBit) == 0) {
            stack.emplace_back(node.child[k], depth + 1);
            continue;
          }
          const LeafRange leaf = LeafRange::Of(node.child[k]);
          for (std::uint32_t t = leaf.first; t < leaf.first + leaf.count; ++t) {
            seen.insert(t);
            for (const Vec3& v : surface.TriangleCorners(t)) ASSERT_TRUE(Holds(node, k, v));
          }
        }
      }
      EXPECT_EQ(seen.size(), object.triangle_count);
    }
  }
}

}  // namespace test_geometry_queries
}  // namespace omni::haptics
