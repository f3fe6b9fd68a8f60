// A point and the pen's ball stroke thirty bodies in six styles, judged by sums over all triangles.
#include <gtest/gtest.h>

#include "tests/support/touch/tip_bodies.h"
#include "tests/support/touch/tip_strokes.h"

namespace omni::haptics {
namespace test_haptics_tips {

constexpr double kPen_m = 0.0015;

double SixVolumes(const InputObject& object) {
  double sum = 0;
  for (const Corners& c : CornersOf(object)) sum += Dot(c[0], Cross(c[1], c[2]));
  return sum;
}

// For a few ticks: `omni-bench tips` has more.
TEST(Tips, StrokesAreFeltExactlyWhereTheTipIsInTheBody) {
  const std::vector<BallBody> bodies = TipBodies();
  ASSERT_GE(bodies.size(), 24U);
  std::uint64_t seed = 41'000;
  for (const BallBody& body : bodies) {
    EXPECT_GT(SixVolumes(body.object), 0) << body.name;
    for (const double radius_m : {0.0, kPen_m}) {
      for (const NamedStyle& style : kStrokeStyles) {
        const BallVerdict verdict =
            JudgeStrokes(body.object, radius_m, style.style, 300, ++seed, [](LeaningPen& pen) { pen.Step(); });
        const std::string what = body.name + ", " + style.name + ", " + std::to_string(radius_m);
        EXPECT_GE(verdict.ticks, 300U) << what;
        EXPECT_EQ(verdict.missed, 0U) << what;
        EXPECT_EQ(verdict.false_contacts, 0U) << what;
        EXPECT_EQ(verdict.inside, 0U) << what;
        EXPECT_EQ(verdict.inverted, 0U) << what;
      }
    }
  }
}

}  // namespace test_haptics_tips
}  // namespace omni::haptics
