// The proxy on views, on smooth faces and at creases.
#include <gtest/gtest.h>

#include "service/haptics/contact/proxy.h"
#include "service/haptics/scene/scene.h"
#include "tests/haptics/oracle.h"
#include "tests/support/surface_queries.h"

namespace omni::haptics {
namespace test_geometry_proxy {

// A scene's mesh under other numbers: with gaps, in reverse.
class Renumbered {
 public:
  explicit Renumbered(const Scene& scene) : surface_(scene, {}), count_(scene.header().triangle_count) {
    for (std::uint32_t t = 0; t < count_; ++t) {
      Triangle copy = surface_.GetTriangle(t);
      for (std::uint32_t& n : copy.neighbour) n = n == kNoIndex ? n : Out(n);
      triangles_.push_back(copy);
    }
  }
  std::uint32_t Out(std::uint32_t t) const noexcept { return 5 * (count_ - t); }
  std::uint32_t In(std::uint32_t t) const noexcept { return count_ - t / 5; }
  Vec3 VertexPosition(std::uint32_t index) const noexcept { return surface_.VertexPosition(index); }
  Corners TriangleCorners(std::uint32_t t) const noexcept { return surface_.TriangleCorners(In(t)); }
  const Triangle& GetTriangle(std::uint32_t t) const noexcept { return triangles_[In(t)]; }

 private:
  Surface surface_;
  std::uint32_t count_;
  std::vector<Triangle> triangles_;
};
static_assert(MeshView<Renumbered>);

TEST(Proxy, RenumberedMeshGivesTheSameProxy) {
  Random random(21);
  const Scene scene = Built(SceneOf(
      Periodic(60, 24, [](double u, double v) { return TorusPoint(0.02, 0.006 + 0.001 * std::cos(7 * u), u, v); })));
  const Surface surface(scene, {});
  const Renumbered view(scene);
  for (int k = 0; k < 2000; ++k) {
    const auto start = static_cast<std::uint32_t>(random.Next() % scene.header().triangle_count);
    const Vec3 target = surface.TriangleCorners(start)[0] + random.InBox(4e-3);
    const ProxyPoint flat = DescendOnSurface(surface, start, target),
                     other = DescendOnSurface(view, view.Out(start), target);
    ASSERT_EQ(other.triangle, view.Out(flat.triangle));
    ASSERT_EQ(other.closest.point, flat.closest.point);
    ASSERT_EQ(NormalAt(view, other), NormalAt(surface, flat));
    ASSERT_EQ(ClassifyProxy(view, other, target, 1), ClassifyProxy(surface, flat, target, 1));
    ASSERT_EQ(OnBorder(view, other.triangle, other.closest.feature, other.closest.index), false);
  }
}

// Wandering deep inside a coarse ball the proxy is the nearest point, whatever the facets; but for rare ticks in which
// only a triangle over the corner is nearer.
TEST(Proxy, FindsTheNearestFacetOfASmoothFace) {
  for (const int n : {6, 10, 20}) {
    const Scene scene = Built(SceneOf(Sphere(n, 0.02)));
    const Surface surface(scene, {});
    Random random(22);
    Vec3 tip{0, 0, 0.018};
    std::uint32_t triangle = support::NearestPoint(surface, scene.objects()[0], tip).triangle;
    int turned = 0;
    for (int k = 0; k < 3000; ++k) {
      tip = (random.Uniform(0.015, 0.0185) / Norm(tip)) * (tip + random.InBox(1e-3));
      const ProxyPoint proxy = DescendOnSurface(surface, triangle, tip);
      triangle = proxy.triangle;
      const NearestResult nearest = BruteNearest(scene, surface, tip);
      ASSERT_LT(proxy.closest.distance_squared, 1.5 * nearest.closest.distance_squared) << n << " " << k;
      const Vec3 is = Normalized(proxy.closest.point - tip), wanted = Normalized(nearest.closest.point - tip);
      turned += Norm(is - wanted) > 0.0175;  // a degree
    }
    EXPECT_LE(turned, 30) << n;
  }
}

// A block's edge is a crease: under the side's own face nothing changes, however near the next face is and however
// finely both are cut.
TEST(Proxy, StaysOnItsFaceAtACrease) {
  for (const int n : {1, 3, 24}) {
    const Scene scene = Built(SceneOf(Block(n, {0.02, 0.02, 0.02})));
    const Surface surface(scene, {});
    std::uint32_t triangle = support::NearestPoint(surface, scene.objects()[0], {0.003, 0.001, 0.0199}).triangle;
    for (double x = 0.003; x < 0.01999; x += 1e-4) {
      const Vec3 tip{x, 0.001, 0.0185};
      const ProxyPoint proxy = DescendOnSurface(surface, triangle, tip);
      triangle = proxy.triangle;
      ASSERT_NEAR(proxy.closest.point.z, 0.02, 1e-15) << n << " " << x;
      ASSERT_NEAR(proxy.closest.point.x, x, 1e-15);
    }
  }
}

TEST(Layout, BlockIsCacheLineAlignedAndInLeafOrder) {
  const Scene scene = Built(SceneOf(Sphere(42, 0.02)));
  const auto at_line = [](const void* p) { return reinterpret_cast<std::uintptr_t>(p) % 64 == 0; };
  EXPECT_TRUE(at_line(scene.vertices().data()) && at_line(scene.triangles().data()));
  EXPECT_TRUE(at_line(scene.nodes().data()));
  EXPECT_LE(static_cast<double>(scene.bytes()) / scene.header().triangle_count, 64);
  std::uint32_t next = 0;
  for (const TreeNode& node : scene.nodes()) {
    for (const std::uint32_t child : node.child) {
      if (child == kNoChild || (child & kLeafBit) == 0) continue;
      ASSERT_EQ(LeafRange::Of(child).first, next);
      next += LeafRange::Of(child).count;
    }
  }
  EXPECT_EQ(next, scene.header().triangle_count);
}

}  // namespace test_geometry_proxy
}  // namespace omni::haptics
