// The hand that touches any model: where it presses.
#include "service/tools/hand/touch_places.h"

#include <gtest/gtest.h>

#include <cmath>

#include "service/haptics/scene/scene.h"
#include "tests/haptics/scenario.h"

namespace omni::tools {
namespace test_tools_hand_path {

using haptics::Vec3;

haptics::Scene Ball(const Vec3& centre_m, double radius_m) {
  return haptics::Built(haptics::SceneOf(
      haptics::CubeGrid(16,
                        [=](const Vec3& p) {
                          const double scale = radius_m / std::hypot(p.x, p.y, p.z);
                          return Vec3{centre_m.x + scale * p.x, centre_m.y + scale * p.y, centre_m.z + scale * p.z};
                        }),
      {}));
}

TEST(HandPath, PressesOnlyWhereTheSurfaceIsFlatEnough) {
  constexpr double kRadius_m = 0.015;
  const Vec3 centre{0.004, -0.003, 0.050};
  const HandPathOptions options;
  const auto script = MakeHandPath(Ball(centre, kRadius_m), options);
  ASSERT_TRUE(script.ok()) << script.error();
  EXPECT_TRUE(script->repeat);
  int presses = 0;
  for (std::size_t i = 1; i < script->waypoints.size(); i += 5) {  // above, below, hold, aside, above
    const Vec3& below = script->waypoints[i].tip_base_m;
    EXPECT_LT(std::hypot(below.x - centre.x, below.y - centre.y), 0.55 * kRadius_m);
    const double top_m =
        centre.z + std::sqrt(kRadius_m * kRadius_m - std::pow(below.x - centre.x, 2) - std::pow(below.y - centre.y, 2));
    EXPECT_NEAR(below.z, top_m - options.press_m, 5e-4);
    ++presses;
  }
  EXPECT_EQ(presses, options.places.places);
}

TEST(HandPath, ErrorGivesReachWhenNothingIsWithinIt) {
  const auto script = MakeHandPath(Ball({0, 0, 0.2}, 0.01), {});
  ASSERT_FALSE(script.ok());
  EXPECT_NE(script.error().find("4.0"), std::string::npos) << script.error();
  EXPECT_NE(script.error().find("--fit"), std::string::npos) << script.error();
}

}  // namespace test_tools_hand_path
}  // namespace omni::tools
