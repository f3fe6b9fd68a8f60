// The ball where only brute force knows its place: loose triangles, ridges and stairs, meshes too fine for it.
#include <gtest/gtest.h>

#include <bit>

#include "service/haptics/contact/ball/ball_in_tree.h"
#include "tests/geometry/ball_scenario.h"
#include "tests/geometry/soup.h"

namespace omni::haptics {
namespace test_geometry_ball_soup {

// A view that counts how many triangles were read.
class CountingSoup : public Soup {
 public:
  using Soup::Soup;
  Corners TriangleCorners(std::uint32_t t) const noexcept {
    ++looked_at;
    return Soup::TriangleCorners(t);
  }
  mutable int looked_at = 0;
};

double NearestOf(const std::vector<Corners>& soup, const Vec3& p) {
  double best = HUGE_VAL;
  for (const Corners& corners : soup) best = std::min(best, ClosestOnTriangle(corners, p).distance_squared);
  return std::sqrt(best);
}

std::vector<Corners> Dust(int count, double half_m, double size_m, Random& random) {
  std::vector<Corners> soup;
  for (int k = 0; k < count; ++k) {
    const Vec3 at = random.InBox(half_m);
    soup.push_back({at + random.InBox(size_m), at + random.InBox(size_m), at + random.InBox(size_m)});
  }
  return soup;
}

// Best gain, in radii, over free places near the centre: as BestGain, for a soup.
double SoupGain(const std::vector<Corners>& soup, double radius_m, const BallState& state, Random& random) {
  constexpr double kReach = 0.02;
  std::vector<Corners> near;
  for (const Corners& c : soup) {
    if (ClosestOnTriangle(c, state.centre_m).distance_squared < std::pow(radius_m * (1 + kReach), 2)) near.push_back(c);
  }
  double best = 0;
  for (int k = 0; k < 300; ++k) {
    const double scale = kReach * radius_m * std::pow(0.5, static_cast<double>(random.Next() % 3));
    const Vec3 at = state.centre_m + scale * Normalized(random.InBox(1));
    const double gain = (Norm(state.centre_m - state.device_point_m) - Norm(at - state.device_point_m)) / radius_m;
    if (gain > best && NearestOf(near, at) >= radius_m) best = gain;
  }
  return best;
}

// Through loose triangles, slowly and in leaps: never too near to any, at rest at a local minimum, and every push is
// the sum of what the touched places say.
TEST(BallInSoup, RestsAtLocalMinima) {
  Random random(1201);
  int rests = 0, touching[4] = {};
  for (int round = 0; round < 24; ++round) {
    const std::vector<Corners> soup = Dust(200, 0.02, round % 2 == 0 ? 0.004 : 0.012, random);
    const Soup view(soup);
    const double radius_m = random.Uniform(2e-4, 3e-3);
    Vec3 tip = random.InBox(0.03);
    BallState state = StartBall(view, view.tree.root, Inside::kNone, radius_m, tip);
    for (int place = 0; place < 40; ++place) {
      const Vec3 goal = random.InBox(0.02);
      const int ticks = place % 4 == 0 ? 1 : 30;
      const Vec3 from = tip;
      BallContact contact;
      for (int k = 1; k <= ticks; ++k) {
        tip = from + (static_cast<double>(k) / ticks) * (goal - from);
        contact = FollowBall(view, view.tree.root, radius_m, tip, state);
        ASSERT_GT(NearestOf(soup, state.centre_m), radius_m * (1 - 2.1 * kBallMargin)) << round << " " << place;
      }
      for (int k = 0; k < 60 && !contact.settled; ++k) {
        contact = FollowBall(view, view.tree.root, radius_m, tip, state);
      }
      if (!contact.settled) continue;
      ++rests;
      ++touching[contact.touch_count];
      if (contact.touch_count == 0) {
        ASSERT_EQ(state.centre_m, tip);
        continue;
      }
      Vec3 sum;
      for (int k = 0; k < contact.touch_count; ++k) {
        const BallTouch& touch = contact.touches[static_cast<std::size_t>(k)];
        sum = sum + touch.share * touch.normal;
        ASSERT_NEAR(Norm(state.centre_m - touch.at.point), radius_m, 3 * kBallMargin * radius_m);
      }
      const double push_m = Norm(state.centre_m - tip);
      ASSERT_LT(Norm(push_m * sum - (state.centre_m - tip)), 2 * kBallMargin * radius_m) << round << " " << place;
      ASSERT_LT(SoupGain(soup, radius_m, state, random), 1e-3) << round << " " << place << " " << contact.touch_count;
    }
  }
  EXPECT_GT(rests, 24 * 40 * 0.9);
  for (int k = 1; k < 4; ++k) EXPECT_GT(touching[k], 30) << k;
}

// Equal states and inputs give equal bits, and a ball at rest stays where it is.
TEST(BallInSoup, IsDeterministicAndStillAtRest) {
  Random random(1202);
  const std::vector<Corners> soup = Dust(300, 0.02, 0.006, random);
  const Soup view(soup), again(soup);
  BallState state = StartBall(view, view.tree.root, Inside::kNone, 1e-3, {0.03, 0, 0}), other = state;
  Vec3 tip{0.03, 0, 0};
  for (int k = 0; k < 3000; ++k) {
    tip = 0.999 * tip + random.InBox(3e-4);
    const BallContact a = FollowBall(view, view.tree.root, 1e-3, tip, state);
    const BallContact b = FollowBall(again, again.tree.root, 1e-3, tip, other);
    ASSERT_EQ(state.centre_m, other.centre_m);
    ASSERT_EQ(a.touch_count, b.touch_count);
    if (k % 100 != 0) continue;
    for (int wait = 0; wait < 100; ++wait) FollowBall(view, view.tree.root, 1e-3, tip, state);
    const Vec3 still = state.centre_m;
    for (int wait = 0; wait < 50; ++wait) {
      FollowBall(view, view.tree.root, 1e-3, tip, state);
      ASSERT_LT(Norm(state.centre_m - still), 0.01 * Norm(still - tip) + 1e-12) << k;
    }
    other = state;
  }
}

// However many triangles there are, and wherever the device point jumps to, a tick reads a bounded number; where they
// all touch the ball at once, it is held, and released when it is pulled away.
TEST(BallInSoup, WorkPerTickIsBoundedOnTooFineMeshes) {
  Random random(1203);
  std::vector<Corners> cup;  // 20000 facets whose middles are all within rounding of one distance
  constexpr double kCup_m = 0.005;
  for (int k = 0; k < 20000; ++k) {
    Vec3 d = Normalized(random.InBox(1));
    d.z = -std::abs(d.z);
    const Vec3 u = Normalized(Cross(d, random.InBox(1))), v = Cross(d, u);
    constexpr double kFacet_m = 1e-7;
    cup.push_back({kCup_m * d + kFacet_m * u, kCup_m * d + kFacet_m * v, kCup_m * d - kFacet_m * (u + v)});
  }
  const CountingSoup view(cup);
  BallState state = StartBall(view, view.tree.root, Inside::kNone, kCup_m * (1 - 1e-7), {0, 0, 0.004});
  int most = 0, held = 0;
  Vec3 tip{0, 0, 0.004};
  for (int k = 0; k < 400; ++k) {
    tip = k % 20 == 0 ? random.InBox(0.02) : 0.9 * tip + random.InBox(2e-3) + Vec3{0, 0, -1e-4};
    view.looked_at = 0;
    const BallContact contact = FollowBall(view, view.tree.root, kCup_m * (1 - 1e-7), tip, state);
    held += !contact.settled && contact.touch_count == 1 && contact.touches[0].share == 1;
    most = std::max(most, view.looked_at);
    ASSERT_GT(NearestOf(cup, state.centre_m), kCup_m * (1 - 3 * kBallMargin)) << k;
  }
  RecordProperty("most", most);
  EXPECT_LT(most, kMaxBallQueries + 8 * kMaxBallNear);  // a move that was begun is finished
  EXPECT_GT(held, 4);
  for (int k = 0; k < 30; ++k) FollowBall(view, view.tree.root, kCup_m * (1 - 1e-7), {0, 0, 0.001 * k}, state);
  EXPECT_EQ(state.centre_m, (Vec3{0, 0, 0.029}));
}

using ProfilePoints = std::vector<std::array<double, 2>>;

ProfilePoints RidgeProfile(double opening_deg) {
  const double half_m = 0.004 * std::tan(0.5 * opening_deg * std::numbers::pi / 180);
  return {{-0.03, 0}, {-half_m, 0}, {0, 0.004}, {half_m, 0}, {0.03, 0}};
}

ProfilePoints StairProfile() {
  ProfilePoints stairs{{-0.03, 0.004}};
  for (int k = 0; k < 5; ++k) {
    stairs.push_back({-0.008 + 0.004 * k, 0.004 - 0.002 * k});
    stairs.push_back({-0.008 + 0.004 * k, 0.002 - 0.002 * k});
  }
  stairs.push_back({0.03, -0.006});
  return stairs;
}

// Strokes over ridges and stairs, coarse and fine: the mesh's triangles have no effect, and wherever the pen stops the
// ball is at a local minimum.
TEST(BallOnProfiles, PathDoesNotDependOnTessellation) {
  Random random(1204);
  for (const ProfilePoints& profile : {RidgeProfile(60), RidgeProfile(90), RidgeProfile(150), StairProfile()}) {
    for (const double radius_m : {3e-4, 1.2e-3}) {
      BallScenario coarse(Built(SceneOf(ProfileSheet(profile, 0.02))), radius_m, {0, 0, 0.02});
      BallScenario fine(Built(SceneOf(ProfileSheet(profile, 0.02, 5, 17))), radius_m, {0, 0, 0.02});
      double worst = 0;
      for (int stroke = 0; stroke < 30; ++stroke) {
        const double y = random.Uniform(-0.01, 0.01), z = random.Uniform(-0.006, 0.003);
        const double from = random.Uniform(-0.012, 0.012), to = random.Uniform(-0.012, 0.012);
        coarse.Restart({from, y, 0.02});
        fine.Restart({from, y, 0.02});
        for (int k = 0; k <= 100; ++k) {
          const Vec3 above{from, y, 0.01}, below{to, y + 0.002, z};
          const Vec3 tip = above + 0.01 * k * (below - above);
          coarse.MoveTo(tip);
          fine.MoveTo(tip);
          worst = std::max(worst, Norm(coarse.state.centre_m - fine.state.centre_m) / radius_m);
        }
        coarse.Rest(60);
        fine.Rest(60);
        ASSERT_LT(BestGain(coarse, 0.02, 200, random), 1e-3);
        ASSERT_LT(BestGain(fine, 0.02, 200, random), 1e-3);
        ASSERT_GT(fine.Gap(), -2.1 * kBallMargin);
      }
      EXPECT_LT(worst, 0.02) << radius_m;
    }
  }
}

}  // namespace test_geometry_ball_soup
}  // namespace omni::haptics
