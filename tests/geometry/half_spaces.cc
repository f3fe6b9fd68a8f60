// The nearest point in half-spaces against every choice of up to three planes.
#include <gtest/gtest.h>

#include <limits>
#include <set>
#include <vector>

#include <Eigen/Dense>

#include "service/haptics/contact/half_spaces.h"
#include "tests/haptics/scenario.h"

namespace omni::haptics {
namespace test_geometry_half_spaces {

bool IsInside(const Vec3& p, const std::vector<HalfSpace>& spaces, double tolerance) {
  return std::all_of(spaces.begin(), spaces.end(),
                     [&](const HalfSpace& s) { return Dot(s.normal, p) >= s.offset - tolerance; });
}

// Nearest point of the planes' common line or point; false if they are too nearly parallel.
bool OnPlanes(const Vec3& goal, const std::vector<HalfSpace>& planes, Vec3& p) {
  const auto n = static_cast<Eigen::Index>(planes.size());
  Eigen::MatrixXd normals(n, 3);
  Eigen::VectorXd missing(n);
  for (Eigen::Index k = 0; k < n; ++k) {
    const HalfSpace& s = planes[static_cast<std::size_t>(k)];
    normals.row(k) << s.normal.x, s.normal.y, s.normal.z;
    missing[k] = s.offset - Dot(s.normal, goal);
  }
  const Eigen::MatrixXd gram = normals * normals.transpose();
  if (std::abs(gram.determinant()) < 1e-9) return false;
  const Eigen::Vector3d step = normals.transpose() * gram.ldlt().solve(missing);
  p = goal + Vec3{step.x(), step.y(), step.z()};
  return true;
}

double BestByEnumeration(const Vec3& goal, const std::vector<HalfSpace>& spaces) {
  double best = std::numeric_limits<double>::infinity();
  const std::size_t n = spaces.size();
  for (std::size_t i = 0; i <= n; ++i) {
    for (std::size_t j = i; j <= n; ++j) {
      for (std::size_t k = j; k <= n; ++k) {
        std::vector<HalfSpace> planes;
        for (const std::size_t at : std::set<std::size_t>{i, j, k}) {
          if (at < n) planes.push_back(spaces[at]);  // n: one plane fewer
        }
        Vec3 p = goal;
        if (!planes.empty() && !OnPlanes(goal, planes, p)) continue;
        if (IsInside(p, spaces, 1e-9)) best = std::min(best, Norm(p - goal));
      }
    }
  }
  return best;
}

std::vector<HalfSpace> RandomSpaces(Random& random, double offset) {
  std::vector<HalfSpace> spaces;
  const std::uint64_t count = random.Next() % 9;
  while (spaces.size() < count) {
    const Vec3 normal = Normalized(random.InBox(1));
    spaces.push_back({normal, random.Next() % 3 == 0 ? 0 : random.Uniform(-1, offset)});
  }
  return spaces;
}

TEST(HalfSpaces, NearestPointMatchesEnumeration) {
  Random random(1101);
  int with[4] = {};
  for (int k = 0; k < 5000; ++k) {
    const std::vector<HalfSpace> spaces = RandomSpaces(random, 0);  // the origin is inside
    const Vec3 goal = random.InBox(1.5);
    const NearestInside found = NearestInHalfSpaces(goal, spaces, 1e-10);
    ASSERT_TRUE(found.feasible);
    ASSERT_TRUE(IsInside(found.point, spaces, 1e-7)) << k;
    const double best = BestByEnumeration(goal, spaces), distance = Norm(found.point - goal);
    ASSERT_NEAR(distance, best, 1e-6 * (1 + best)) << k;
    ++with[found.active_count];
    Vec3 push;
    const auto shares = Multipliers(found, spaces, found.point - goal);
    for (std::size_t a = 0; a < static_cast<std::size_t>(found.active_count); ++a) {
      push = push + shares[a] * spaces[static_cast<std::size_t>(found.active[a])].normal;
    }
    ASSERT_LT(Norm(push - (found.point - goal)), 1e-6 * (1 + distance)) << k;
  }
  for (const int count : with) EXPECT_GT(count, 100);
}

// With offsets of either sign there may be no common point; where one is reported it is one.
TEST(HalfSpaces, ReportsInfeasibleSets) {
  Random random(1102);
  int none = 0, some = 0;
  for (int k = 0; k < 5000; ++k) {
    const std::vector<HalfSpace> spaces = RandomSpaces(random, 0.7);
    const Vec3 goal = random.InBox(1.5);
    const NearestInside found = NearestInHalfSpaces(goal, spaces, 1e-10);
    const double best = BestByEnumeration(goal, spaces);
    if (found.feasible) {
      ASSERT_TRUE(IsInside(found.point, spaces, 1e-6)) << k;
      ASSERT_NEAR(Norm(found.point - goal), best, 1e-5 * (1 + best)) << k;
    } else {
      ASSERT_TRUE(std::isinf(best) || best > 100) << k;
    }
    ++(found.feasible ? some : none);
  }
  EXPECT_GT(none, 20);
  EXPECT_GT(some, 2000);
}

}  // namespace test_geometry_half_spaces
}  // namespace omni::haptics
