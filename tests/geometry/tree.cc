// The tree over the worst meshes: results match testing every triangle, bit by bit.
#include <gtest/gtest.h>

#include <cstring>
#include <set>

#include "tests/geometry/soup.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_geometry_tree {

struct NamedSoup {
  const char* name;
  Soup soup;
  double size_m;
};

std::vector<Corners> Make(int count, Random& random, const std::function<Corners(int, Random&)>& make) {
  std::vector<Corners> corners;
  corners.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) corners.push_back(make(i, random));
  return corners;
}

Corners Around(const Vec3& centre, double size_m, Random& random) {
  return {centre + random.InBox(size_m), centre + random.InBox(size_m), centre + random.InBox(size_m)};
}

std::vector<NamedSoup> Soups(std::uint64_t seed) {
  Random random(seed);
  const auto soup = [&](const char* name, double size_m, int count, auto make) {
    return NamedSoup{name, Soup(Make(count, random, make)), size_m};
  };
  const Corners one = Around({}, 0.02, random);
  std::vector<NamedSoup> soups;
  soups.push_back(soup("dust", 0.05, 900, [](int, Random& r) { return Around(r.InBox(0.05), 2e-3, r); }));
  soups.push_back(soup("one", 0.05, 1, [&](int, Random&) { return one; }));
  soups.push_back(soup("five", 0.05, 5, [](int, Random& r) { return Around(r.InBox(0.03), 0.01, r); }));
  soups.push_back(soup("the same 300 times", 0.05, 300, [&](int, Random&) { return one; }));
  soups.push_back(soup("one centre, growing", 0.05, 300, [](int i, Random&) {
    const double r = 1e-5 * std::pow(1.03, i);
    return Corners{Vec3{r, 0, 0}, Vec3{-0.5 * r, 0.87 * r, 0}, Vec3{-0.5 * r, -0.87 * r, 0}};
  }));
  soups.push_back(soup("needles", 0.05, 500, [](int, Random& r) {
    const Vec3 a = r.InBox(0.05), b = r.InBox(0.05);
    return Corners{a, b, a + 0.37 * (b - a) + r.InBox(1e-9)};
  }));
  soups.push_back(soup("without area", 0.05, 200, [](int i, Random& r) {
    const Vec3 a = r.InBox(0.05), b = r.InBox(0.05);
    return i % 2 == 0 ? Corners{a, a, a} : Corners{a, b, a + 0.5 * (b - a)};
  }));
  soups.push_back(soup("flat", 0.05, 800, [](int i, Random&) {
    const int square = i / 2;
    const int column = square % 20, row = square / 20;
    const double x = 2e-3 * column - 0.02, y = 2e-3 * row - 0.02, d = 2e-3;
    return i % 2 == 0 ? Corners{Vec3{x, y, 0}, Vec3{x + d, y, 0}, Vec3{x + d, y + d, 0}}
                      : Corners{Vec3{x, y, 0}, Vec3{x + d, y + d, 0}, Vec3{x, y + d, 0}};
  }));
  soups.push_back(soup("far and fine", 9.9, 500, [](int, Random& r) { return Around(r.InBox(9.9), 1e-5, r); }));
  soups.push_back(soup("every scale", 0.5, 700, [](int i, Random& r) {
    const double scale = std::pow(0.97, i);
    return Around(r.InBox(0.5 * scale), 0.1 * scale, r);
  }));
  return soups;
}

Vec3 Somewhere(const NamedSoup& named, int k, Random& random) {
  const Corners c =
      named.soup.TriangleCorners(Soup::NumberOf(static_cast<std::uint32_t>(random.Next() % named.soup.size())));
  switch (k % 5) {
    case 0:
      return random.InBox(1.2 * named.size_m);
    case 1:
      return c[0];
    case 2:
      return c[0] + random.Uniform(0, 1) * (c[1] - c[0]);
    case 3:
      return (1.0 / 3) * (c[0] + c[1] + c[2]) + random.InBox(1e-4);
    default:
      return c[2] + random.InBox(0.2 * named.size_m);
  }
}

TEST(Tree, NearestMatchesBruteForce) {
  Random random(11);
  for (const NamedSoup& named : Soups(1)) {
    const Soup& soup = named.soup;
    for (int k = 0; k < 300; ++k) {
      const Vec3 p = Somewhere(named, k, random);
      double least = 1e300;
      for (std::uint32_t i = 0; i < soup.size(); ++i) {
        least = std::min(least, ClosestOnTriangle(soup.TriangleCorners(Soup::NumberOf(i)), p).distance_squared);
      }
      const NearestResult found = NearestInTree(soup, soup.tree.root, p);
      ASSERT_EQ(found.closest.distance_squared, least) << named.name << " " << k;
      const auto known = Soup::NumberOf(static_cast<std::uint32_t>(random.Next() % soup.size()));
      ASSERT_EQ(NearestInTree(soup, soup.tree.root, p, 1e3, known).closest.distance_squared, least) << named.name;
      if (!(least > 1e-20)) continue;
      const double distance_m = std::sqrt(least);
      ASSERT_NE(NearestInTree(soup, soup.tree.root, p, 1.0001 * distance_m).triangle, kNoIndex) << named.name;
      ASSERT_EQ(NearestInTree(soup, soup.tree.root, p, 0.9999 * distance_m).triangle, kNoIndex) << named.name;
    }
  }
}

TEST(Tree, CrossingMatchesBruteForce) {
  Random random(12);
  int hits = 0;
  for (const NamedSoup& named : Soups(2)) {
    const Soup& soup = named.soup;
    for (int k = 0; k < 300; ++k) {
      const Vec3 a = Somewhere(named, k, random);
      const Vec3 b = k % 3 == 0 ? Somewhere(named, k / 3, random) : a + random.InBox(k % 3 == 1 ? 1e-3 : 1e-6);
      double first[2] = {2, 2};  // from the front only, from both sides
      for (std::uint32_t i = 0; i < soup.size(); ++i) {
        const TriangleHit hit = IntersectTriangle(soup.TriangleCorners(Soup::NumberOf(i)), a, b);
        if (hit.hit) first[1] = std::min(first[1], hit.t);
        if (hit.hit && hit.front) first[0] = std::min(first[0], hit.t);
      }
      for (const bool both : {false, true}) {
        const CrossingResult found = CrossingInTree(soup, soup.tree.root, a, b, both);
        ASSERT_EQ(found.t, first[both]) << named.name << " " << k;
        hits += found.triangle != kNoIndex;
      }
    }
  }
  EXPECT_GT(hits, 500);
}

// Floats only exclude: no bound they give lies above the truth by more than the slack.
TEST(Tree, FloatBoundsNeverExceedTheDistance) {
  Random random(13);
  double tightest = 1, widest = 0;
  for (const NamedSoup& named : Soups(3)) {
    const Soup& soup = named.soup;
    for (int k = 0; k < 200; ++k) {
      const Vec3 p = Somewhere(named, k, random);
      const double slack_m = FloatSlack(soup.TreeExtent(), LargestComponent(p));
      for (const LeafRange& leaf : soup.Leaves()) {
        alignas(16) float bound[kLeafSize];
        _mm_store_ps(bound, BoundTriangles(soup.RestCorners(leaf), Broadcast(p)).DistanceSquared());
        for (std::uint32_t lane = 0; lane < leaf.count; ++lane) {
          if (!(bound[lane] > 0)) continue;
          const double truth =
              std::sqrt(ClosestOnTriangle(soup.TriangleCorners(leaf.first + lane), p).distance_squared);
          const double claimed = std::sqrt(double{bound[lane]});
          ASSERT_LE(claimed, truth + slack_m) << named.name;
          widest = std::max(widest, (claimed - truth) / slack_m);
          if (std::strcmp(named.name, "dust") == 0 && truth > 1e-3) tightest = std::min(tightest, claimed / truth);
        }
      }
    }
  }
  EXPECT_LT(widest, 0.5) << "half of the slack is spare";
  EXPECT_GT(tightest, 0.999) << "a bound that excludes nothing is no bound";
}

TEST(Tree, DepthIsBoundedAndBoxesHoldEveryTriangle) {
  for (const NamedSoup& named : Soups(4)) {
    const Soup& soup = named.soup;
    std::vector<std::pair<std::uint32_t, int>> stack{{soup.tree.root, 1}};
    std::multiset<std::uint32_t> seen;
    while (!stack.empty()) {
      const auto [index, depth] = stack.back();
      stack.pop_back();
      ASSERT_LE(depth, kMaxTreeDepth) << named.name;
      const TreeNode& node = soup.Node(index);
      for (int k = 0; k < kTreeWidth; ++k) {
        if (node.child[k] == kNoChild) continue;
        if ((node.child[k] & kLeafBit) == 0) {
          stack.emplace_back(node.child[k], depth + 1);
          continue;
        }
        const LeafRange leaf = LeafRange::Of(node.child[k]);
        for (std::uint32_t t = leaf.first; t < leaf.first + leaf.count; ++t) {
          seen.insert(t);
          for (const Vec3& v : soup.TriangleCorners(t)) {
            const double x[3] = {v.x, v.y, v.z};
            for (int axis = 0; axis < 3; ++axis) {
              ASSERT_LE(node.lower[axis][k], x[axis]) << named.name;
              ASSERT_GE(node.upper[axis][k], x[axis]) << named.name;
            }
          }
        }
      }
    }
    ASSERT_EQ(seen.size(), soup.size()) << named.name;
    ASSERT_EQ(std::set<std::uint32_t>(seen.begin(), seen.end()).size(), soup.size()) << named.name;
  }
}

// Centres that every cut by the surface-area heuristic peels off one by one.
TEST(Tree, DepthIsBoundedWhenCutsPeelSingleTriangles) {
  std::vector<Corners> corners;
  for (int i = 0; i < 20'000; ++i) {
    const double x = 9 * std::pow(0.9985, i);
    corners.push_back({Vec3{x, 0, 0}, Vec3{x * 1.0001, 1e-7, 0}, Vec3{x, 0, 1e-7}});
  }
  const Soup soup(corners);
  std::vector<std::pair<std::uint32_t, int>> stack{{soup.tree.root, 1}};
  int deepest = 0;
  while (!stack.empty()) {
    const auto [index, depth] = stack.back();
    stack.pop_back();
    deepest = std::max(deepest, depth);
    for (const std::uint32_t child : soup.Node(index).child) {
      if ((child & kLeafBit) == 0) stack.emplace_back(child, depth + 1);
    }
  }
  EXPECT_LE(deepest, kMaxTreeDepth);
}

TEST(Tree, BuildIsDeterministic) {
  const std::vector<NamedSoup> first = Soups(5), second = Soups(5);
  for (std::size_t i = 0; i < first.size(); ++i) {
    const Soup &a = first[i].soup, &b = second[i].soup;
    ASSERT_EQ(a.nodes.size(), b.nodes.size());
    EXPECT_EQ(std::memcmp(a.nodes.data(), b.nodes.data(), a.nodes.size() * sizeof(TreeNode)), 0) << first[i].name;
  }
}

TEST(Tree, NonFinitePointsFindNothing) {
  Random random(6);
  const Soup soup(Make(50, random, [](int, Random& r) { return Around(r.InBox(0.05), 2e-3, r); }));
  const double nan = std::nan("");
  EXPECT_EQ(NearestInTree(soup, soup.tree.root, {nan, 0, 0}).triangle, kNoIndex);
  EXPECT_EQ(CrossingInTree(soup, soup.tree.root, {nan, 0, 0}, {0, 0, nan}, true).triangle, kNoIndex);
}

}  // namespace test_geometry_tree
}  // namespace omni::haptics
