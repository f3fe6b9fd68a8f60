// Within a micrometre of a concave edge a tip is in front of one wall and behind the other; no contact may be lost
// there.
#include <gtest/gtest.h>

#include "tests/haptics/oracle.h"
#include "tests/support/surface_queries.h"

namespace omni::haptics {
namespace test_geometry_concave {

// A ring with a groove on top: its bottom, a concave edge, runs at r = 26 mm, z = 6 mm; walls at 63 degrees.
InputObject Groove(int around, int pieces) {
  constexpr int kProfile = 6;
  constexpr std::array<std::array<double, 2>, kProfile> profile = {
      {{0.018, -0.010}, {0.034, -0.010}, {0.034, 0.010}, {0.028, 0.010}, {0.026, 0.006}, {0.024, 0.010}}};
  return Periodic(around, kProfile * pieces, [=](double u, double v) {
    const double y = v * kProfile / (2 * std::numbers::pi) + 1e-9;
    const auto k = static_cast<std::size_t>(y) % kProfile;
    const double s = std::max(0.0, y - std::floor(y) - 1e-9);
    const auto& a = profile[k];
    const auto& b = profile[(k + 1) % kProfile];
    const double r = a[0] + s * (b[0] - a[0]);
    return Vec3{r * std::cos(u), r * std::sin(u), a[1] + s * (b[1] - a[1])};
  });
}

TEST(ConcaveEdge, NoMissedOrFalseContactWhileCrossing) {
  Material m;
  m.static_friction = m.dynamic_friction = 0;
  for (const int pieces : {1, 6}) {
    const Scene scene = Built(SceneOf(Groove(96, pieces), m));
    ASSERT_NE(scene.objects()[0].flags & kClosed, 0U);
    const Surface surface(scene, {});
    Random random(41);
    Pen pen(scene);
    int inside = 0, missed = 0, wrong = 0;
    for (int k = 0; k < 4000; ++k) {
      const double u = random.Uniform(0, 6.28), side = k % 2 == 0 ? 1 : -1;
      const auto at = [&](double r, double z, double turn) {
        return Vec3{r * std::cos(u + turn), r * std::sin(u + turn), z};
      };
      // Facets sag by up to 14 um between the corners of the edge: the foot on the mesh is the edge.
      const NearestResult bottom = support::NearestPoint(surface, scene.objects()[0], at(0.026, 0.006, 0));
      const Vec3 edge = bottom.closest.point;
      pen.MoveTo(at(0.026, 0.012, 0));
      pen.MoveTo(edge + Vec3{0, 0, 1e-5});
      pen.MoveTo(edge + at(1e-4 * side, -1e-4, 0));
      pen.MoveTo(edge + random.InBox(k % 3 == 0 ? 1e-8 : 1e-6));
      const Vec3 tip = edge + at(-1e-4 * side, -1e-4, 0);
      pen.MoveTo(tip);
      const NearestResult nearest = support::NearestPoint(surface, scene.objects()[0], tip);
      const bool is_inside = SideOf(surface, nearest, tip) < 0;
      inside += is_inside;
      missed += is_inside && !(pen.output.tip_normal_force_N > 0);
      wrong += !is_inside && pen.output.tip_normal_force_N > 0;
    }
    EXPECT_EQ(missed, 0) << pieces;
    EXPECT_EQ(wrong, 0) << pieces;
    EXPECT_GT(inside, 3000);
  }
}

}  // namespace test_geometry_concave
}  // namespace omni::haptics
