// Over random walls, motions and states: no wall is passed, no energy gained, no invalid value propagated.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "service/base/force_limit.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/vehicle/car_force.h"
#include "tests/support/alloc_probe.h"
#include "tests/vehicle/scene.h"

namespace omni::haptics {
namespace test_vehicle_walls {

// Twisted blocks and thin plates, corners and slits between them, in a fence.
SceneInput Maze(Random& random) {
  SceneInput input = SceneOf(Block(1, {0.001, 0.001, 0.001}, {1, 1, 1}));
  input.materials[0].restitution = random.Uniform(0, 1);
  for (int k = 0; k < 12; ++k) {
    const double angle = random.Uniform(0, 3.2), x = random.Uniform(-0.04, 0.04), y = random.Uniform(-0.04, 0.04);
    InputObject wall = Block(1 + k % 3, {random.Uniform(0.001, 0.02), random.Uniform(0.0001, 0.004), 0.002});
    for (Vec3& p : wall.vertices_base_m) {
      p = {x + p.x * std::cos(angle) - p.y * std::sin(angle), y + p.x * std::sin(angle) + p.y * std::cos(angle), p.z};
    }
    wall.car_wall = true;
    input.objects.push_back(wall);
  }
  for (int k = 0; k < 4; ++k) {  // a fence around
    const double side = k % 2 == 0 ? 0.08 : -0.08;
    input.objects.push_back(k < 2 ? Block(1, {0.081, 0.001, 0.002}, {0, side, 0})
                                  : Block(1, {0.001, 0.081, 0.002}, {side, 0, 0}));
    input.objects.back().car_wall = true;
  }
  input.vehicle.emplace().start_base_m = {0, 0, 0.0005};
  return input;
}

// Segment a-b crosses c-d.
bool Crosses(const Vec3& a, const Vec3& b, const WallSegment& s) {
  const auto side = [](double px, double py, double qx, double qy, double rx, double ry) {
    return (qx - px) * (ry - py) - (qy - py) * (rx - px);
  };
  return side(a.x, a.y, b.x, b.y, s.ax, s.ay) * side(a.x, a.y, b.x, b.y, s.bx, s.by) < 0 &&
         side(s.ax, s.ay, s.bx, s.by, a.x, a.y) * side(s.ax, s.ay, s.bx, s.by, b.x, b.y) < 0;
}

// A free place in a maze; found by search, so that the car does not begin inside a wall.
bool PutSomewhere(Random& random, Driver& driver) {
  StartCar(driver.car(), driver.state);
  for (int k = 0; k < 100; ++k) {
    driver.state.position_base_m = {random.Uniform(-0.06, 0.06), random.Uniform(-0.06, 0.06), 0.0005};
    if (!NearestWall(driver.walls(), driver.state.position_base_m, driver.car().radius_m).found) return true;
  }
  return false;
}

void Throw(Random& random, double fastest_m_s, VehicleState& state) {
  const double speed_m_s = fastest_m_s * std::pow(10, random.Uniform(-4, 0)), way = random.Uniform(-3.2, 3.2);
  state.velocity_base_m_s = {speed_m_s * std::cos(way), speed_m_s * std::sin(way), 0};
  state.heading_rad = random.Uniform(-3.2, 3.2);
  state.yaw_rate_rad_s = random.Uniform(-30, 30);
}

// The touch found by the tree is the one found by stepping along in small steps.
TEST(Walls, FirstTouchMatchesSmallSteps) {
  Random random(11);
  int touches = 0, seen = 0;
  for (int m = 0; m < 20; ++m) {
    Driver driver(Built(Maze(random)));
    for (int k = 0; k < 40 && PutSomewhere(random, driver); ++k) {
      const Vec3 p = driver.state.position_base_m;
      const Vec3 motion{random.Uniform(-0.05, 0.05), random.Uniform(-0.05, 0.05), 0};
      const double radius_m = driver.car().radius_m;
      const WallTouch touch = FirstTouch(driver.walls(), p, motion, radius_m);
      constexpr int kSteps = 2000;
      int first = kSteps + 1;
      for (int i = 0; i <= kSteps && first > kSteps; ++i) {
        if (NearestWall(driver.walls(), p + (static_cast<double>(i) / kSteps) * motion, radius_m * (1 - 1e-9)).found) {
          first = i;
        }
      }
      touches += touch.found;
      if (touch.found) {
        EXPECT_NEAR(NearestWall(driver.walls(), p + touch.share * motion, 1).distance_m, radius_m, 1e-12);
        EXPECT_NEAR(Norm(touch.normal), 1, 1e-12);
      }
      // Steps may miss a graze between two of them, never the other way round.
      if (first <= kSteps) {
        ASSERT_TRUE(touch.found);
        ++seen;
        EXPECT_LE(touch.share, (first + 1e-6) / kSteps);
      }
    }
  }
  EXPECT_GT(touches, 250);
  EXPECT_GT(seen, 0.9 * touches) << "hardly any touch is one that steps do not see";
}

// Kinetic energy per mass, of the motion and of the turn, m^2/s^2.
double EnergyPerMass(const VehicleInput& car, const VehicleState& state) {
  const double turns_1_s2 = state.yaw_rate_rad_s * state.yaw_rate_rad_s;
  return 0.5 * (SquaredNorm(state.velocity_base_m_s) + GyrationSquared_m2(car) * turns_1_s2);
}

TEST(Walls, CarDoesNotPassThroughOrGainEnergy) {
  Random random(7);
  std::uint32_t hits = 0;
  for (int m = 0; m < 40; ++m) {
    Driver driver(Built(Maze(random)));
    for (int k = 0; k < 60 && PutSomewhere(random, driver); ++k) {
      Throw(random, 200, driver.state);
      for (int tick = 0; tick < 30; ++tick) {
        const VehicleState before = driver.state;
        driver.Coast(random.Uniform(0, 5e-3));
        const double energy = EnergyPerMass(driver.car(), before);
        ASSERT_LE(EnergyPerMass(driver.car(), driver.state), energy * (1 + 1e-9) + 1e-18);
        const Wall wall = NearestWall(driver.walls(), driver.state.position_base_m, 1);
        ASSERT_GT(wall.distance_m, driver.car().radius_m * (1 - 1e-6)) << "maze " << m;
        // What moves straight for a whole tick crosses nothing on it.
        const Vec3 straight = driver.state.position_base_m - before.position_base_m;
        if (driver.state.hits == before.hits && driver.state.velocity_base_m_s == before.velocity_base_m_s) {
          for (const WallSegment& s : driver.walls().segments) {
            ASSERT_FALSE(Crosses(before.position_base_m, before.position_base_m + straight, s));
          }
        }
      }
      hits += driver.state.hits;
    }
  }
  EXPECT_GT(hits, 5000U);
}

// Off track, tyres, engine and walls together: speeds stay what the engine can give.
TEST(Walls, DriveAmongWallsStaysBelowTopSpeed) {
  Random random(3);
  for (int m = 0; m < 10; ++m) {
    Driver driver(Built(Maze(random)));
    if (!PutSomewhere(random, driver)) continue;
    Thumbstick stick;
    for (int k = 0; k < 5000; ++k) {
      if (k % 200 == 0) stick = {random.Uniform(-0.7, 0.7), random.Uniform(-0.7, 0.7)};
      driver.Go(stick);
      ASSERT_LT(driver.Speed(), driver.car().speed_max_m_s * 1.05);
      ASSERT_GT(NearestWall(driver.walls(), driver.state.position_base_m, 1).distance_m,
                driver.car().radius_m * (1 - 1e-6));
    }
  }
}

TEST(Walls, EqualDrivesGiveEqualBits) {
  Random build(21);
  const Scene scene = Built(Maze(build));
  std::array<VehicleState, 2> end;
  std::memset(static_cast<void*>(&end), 0, sizeof end);
  for (VehicleState& state : end) {
    Random random(22);
    Driver driver(scene);
    for (int k = 0; k < 5000; ++k) driver.Go({random.Uniform(-1, 1), random.Uniform(-1, 1)});
    state.position_base_m = driver.state.position_base_m;
    state.velocity_base_m_s = driver.state.velocity_base_m_s;
    state.heading_rad = driver.state.heading_rad;
    state.hits = driver.state.hits;
  }
  EXPECT_EQ(std::memcmp(&end[0], &end[1], sizeof(VehicleState)), 0);
}

TEST(Walls, AbsurdStatesAreClamped) {
  Random random(9);
  Driver driver(Built(Maze(random)));
  const double odd[] = {std::nan(""), std::numeric_limits<double>::infinity(), -1e300, 1e12, 1e-310, 0.0};
  for (const double x : odd) {
    for (const double r : odd) {
      ASSERT_TRUE(PutSomewhere(random, driver));
      driver.state.velocity_base_m_s = {x, r, 0};
      driver.state.yaw_rate_rad_s = r;
      for (int k = 0; k < 50; ++k) driver.Coast(5e-3);
      EXPECT_TRUE(IsWithin(driver.state.position_base_m, 1e3)) << x << " " << r;
      EXPECT_TRUE(IsWithin(driver.state.velocity_base_m_s, 1e3)) << x << " " << r;
      EXPECT_TRUE(std::isfinite(driver.state.heading_rad));
    }
  }
}

base::ForceLimit RandomLimit(Random& random) {
  base::ForceLimit limit = test::UsualLimit();
  limit.force_max_N = random.Uniform(0.05, 3);
  for (double& a : limit.ampere_per_newton) a += random.Uniform(-8, 8);
  for (double& a : limit.bias_A) a = random.Uniform(-3, 3);
  for (double& r : limit.resistance_ohm) r = random.Uniform(0.5, 1);
  limit.power_max_W = random.Uniform(30, 600);
  return limit;
}

TEST(Pulses, GrowWithSpeedWithinForceAndSlewLimits) {
  Random random(31);
  int rendered = 0;
  for (int m = 0; m < 2000; ++m) {
    VehicleInput car;
    car.hit_force_N = random.Uniform(0.1, 2);
    car.hit_speed_m_s = 0.5;
    car.hit_duration_s = random.Uniform(0.02, 0.04);
    const base::ForceLimit limit = RandomLimit(random);
    Vec3 others_N = random.InBox(0.5);
    others_N = base::FeasibleScale(limit, others_N) * others_N;
    const double angle = random.Uniform(-3.2, 3.2);
    car.hit_to_base = random.Uniform(0, 1);
    const Vec3 normal = HitDirection(car, {std::cos(angle), std::sin(angle), 0}, random.InBox(0.06));
    ASSERT_NEAR(Norm(normal), 1, 1e-12);
    const PulseLimits limits{limit, others_N, 850};
    double last_N = 0;
    for (int k = 0; k < 20; ++k) {
      const double speed_m_s = 0.05 * std::pow(40.0, k / 19.0);
      VehicleState state;
      Impacts impacts;
      impacts.count = 1;
      impacts.of[0] = {speed_m_s, normal, 0};
      StartPulses(car, limits, impacts, state);
      double peak_N = 0;
      Vec3 before;
      for (int tick = 0; tick < 45; ++tick) {
        const Vec3 force_N = AdvancePulses(car, limits, 1e-3, state).force_N;
        ASSERT_GE(base::FeasibleScale(limit, others_N + force_N), 1 - 1e-9);
        ASSERT_LE(Norm(force_N - before), 0.85 * (1 + 1e-9));
        before = force_N;
        peak_N = std::max(peak_N, Norm(force_N));
      }
      if (Headroom_N(limit, others_N, normal) < 1e-9) continue;
      ASSERT_GT(peak_N, last_N) << m << " " << speed_m_s;
      last_N = peak_N;
      ++rendered;
    }
  }
  EXPECT_GT(rendered, 20'000);
}

// Headroom is the largest that fits: a little less does, a little more does not.
TEST(Pulses, HeadroomIsExact) {
  Random random(32);
  for (int m = 0; m < 5000; ++m) {
    const base::ForceLimit limit = RandomLimit(random);
    Vec3 others_N = random.InBox(0.6);
    others_N = 0.98 * base::FeasibleScale(limit, others_N) * others_N;
    const Vec3 direction = Normalized(random.InBox(1));
    const double room_N = Headroom_N(limit, others_N, direction);
    if (base::FeasibleScale(limit, others_N) < 1) {
      EXPECT_EQ(room_N, 0);
      continue;
    }
    EXPECT_EQ(base::FeasibleScale(limit, others_N + (room_N * (1 - 1e-9)) * direction), 1);
    EXPECT_LT(base::FeasibleScale(limit, others_N + (room_N * (1 + 1e-6) + 1e-9) * direction), 1);
  }
}

// The whole of it through Step, the pen and its limits at random: finite, feasible, no allocation.
TEST(Play, ForceIsBoundedWithoutAllocationForRandomInputs) {
  Random random(41);
  SceneInput input = Maze(random);
  JoystickInput& stick = input.joystick.emplace();
  stick.centre_base_m = {0, 0, 0.05};
  stick.radial_detents = 3;
  stick.angular_detents = 8;
  Pen pen(Built(input));
  Vec3 tip{0, 0, 0.05};
  for (int k = 0; k < 30'000; ++k) {
    if (k % 100 == 0) pen.input.limit = RandomLimit(random);
    if (k % 97 == 0) pen.state.vehicle.velocity_base_m_s = random.InBox(2);
    pen.state.vehicle.velocity_base_m_s.z = 0;
    pen.input.tracked = k % 1000 > 20;
    tip = tip + random.InBox(0.001);
    if (Norm(tip - stick.centre_base_m) > 0.02) tip = stick.centre_base_m;
    const loop::AllocProbe probe;
    pen.MoveTo(tip);
    ASSERT_EQ(probe.count(), 0U);
    ASSERT_TRUE(IsWithin(pen.output.force_base_N, 3));
    ASSERT_TRUE(pen.output.force_base_N == Vec3{} || !pen.input.tracked ||
                base::FeasibleScale(pen.input.limit, pen.output.force_base_N) >= 1 - 1e-9);
  }
  EXPECT_GT(pen.output.vehicle.hits, 100U);
}

}  // namespace test_vehicle_walls
}  // namespace omni::haptics
