// Forces and constraints of an application, tick by tick: bounded, without kicks, ended in time, stable in a delayed
// loop.
#include "service/haptics/applied/applied.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <random>

#include "service/base/vec.h"

namespace omni::haptics {

using base::Vec3;
namespace test_haptics_applied {

constexpr double kTick_s = 1e-3;

StiffnessBound Generous() {
  return {.stiffness_N_m = 500, .along_N_m = 500, .axis_base = {0, 0, -1}, .damping_Ns_m = 1, .predict_s = 0};
}

// One application and a pen that the test moves.
struct Bench {
  AppliedConfig config;
  AppliedCommand command{.open = true};
  AppliedInput input{.t_ns = 1'000'000'000, .tracked = true, .bound = Generous()};
  AppliedState state;
  AppliedOutput output;

  Vec3 Tick() {
    input.t_ns += 1'000'000;
    if (IsAtRest(command, state)) {
      output = {};
      return {};
    }
    ComputeAppliedForce(config, command, input, state, output);
    return output.force_base_N;
  }
  void Push(const Vec3& force_N, double seconds, double ramp_s = 0) {
    ++command.force_id;
    command.force_base_N = force_N;
    command.force_end_ns = input.t_ns + static_cast<std::int64_t>(1e9 * seconds);
    command.ramp_s = ramp_s;
  }
  void Set(std::initializer_list<Constraint> constraints) {
    ++command.constraints_id;
    command.constraints_t_ns = input.t_ns;
    command.constraint_count = 0;
    for (const Constraint& c : constraints) command.constraints[command.constraint_count++] = c;
  }
  // Milliseconds until the force is exactly zero; -1: never.
  int TicksToZero(int most = 100) {
    for (int i = 1; i <= most; ++i) {
      if (Tick() == Vec3{}) return i;
    }
    return -1;
  }
};

Constraint Spring(double stiffness_N_m, const Vec3& point = {}) {
  return {.kind = ConstraintKind::kPoint, .stiffness_N_m = stiffness_N_m, .max_force_N = 10, .point_base_m = point};
}

TEST(Applied, ForceLastsItsDurationThenFadesToZero) {
  Bench bench;
  bench.Push({0.5, 0, 0}, 0.050);
  for (int i = 0; i < 20; ++i) bench.Tick();
  EXPECT_NEAR(bench.output.force_base_N.x, 0.5, 1e-12);
  EXPECT_TRUE(bench.output.acts);
  for (int i = 20; i < 49; ++i) EXPECT_NEAR(bench.Tick().x, 0.5, 1e-12) << i;
  const int ms = bench.TicksToZero();
  EXPECT_GE(ms, 5) << "it fades";
  EXPECT_LE(ms, 20);
  EXPECT_FALSE(bench.output.acts);
}

TEST(Applied, RenewedForceContinuesWithoutGap) {
  Bench bench;
  for (int frame = 0; frame < 50; ++frame) {
    bench.Push({0, 0.4, 0}, 0.030);
    for (int i = 0; i < 11; ++i) bench.Tick();
    EXPECT_TRUE(frame == 0 || std::abs(bench.output.force_base_N.y - 0.4) < 1e-12) << frame;
  }
}

TEST(Applied, ForceRampsUpOverTheRequestedTime) {
  Bench bench;
  bench.Push({0, 0, 1}, 0.1, 0.040);
  double last = 0;
  for (int i = 1; i <= 40; ++i) {
    const double f = bench.Tick().z;
    EXPECT_GE(f, last);
    EXPECT_LE(f, i / 40.0 + 1e-12);
    last = f;
  }
  EXPECT_NEAR(last, 1, 1e-9);
}

// Everything that ends a force ends it within 20 ms, without a kick.
TEST(Applied, ForceEndsWithin20MillisecondsForEveryCause) {
  const auto endings = std::array{
      +[](Bench& b) { b.command.open = false; },
      +[](Bench& b) { b.input.allowed = false; },
      +[](Bench& b) { b.input.tracked = false; },
      +[](Bench& b) {
        ++b.command.force_id;
        b.command.force_end_ns = std::numeric_limits<std::int64_t>::min();
        b.Set({});
      },
  };
  for (std::size_t e = 0; e < endings.size(); ++e) {
    Bench bench;
    bench.input.device_point_base_m = {0.004, 0, 0};
    bench.Set({Spring(300)});
    for (int i = 0; i < 200; ++i) {
      if (i % 20 == 0) bench.Push({0, 0.6, 0}, 0.1);
      bench.Tick();
    }
    ASSERT_GT(Norm(bench.output.force_base_N), 1.0);
    endings[e](bench);
    const int ms = bench.TicksToZero();
    EXPECT_GE(ms, 2) << "ending " << e;
    EXPECT_LE(ms, 20) << "ending " << e;
  }
}

// A device whose stamps stand still must not keep a force alive: the service ends it by its own clock.
TEST(Applied, ForceEndsWhenDeviceTimestampsStall) {
  Bench bench;
  bench.Push({0.5, 0, 0}, 0.1);
  for (int i = 0; i < 20; ++i) bench.Tick();
  bench.command.force_end_ns = std::numeric_limits<std::int64_t>::min();  // as ForceClients::MakeCommand
  bench.input.dt_s = 0;
  int ticks = 0;
  for (; ticks < 50 && bench.output.force_base_N != Vec3{}; ++ticks) {
    ComputeAppliedForce(bench.config, bench.command, bench.input, bench.state, bench.output);
  }
  EXPECT_LE(ticks, 20);
}

TEST(Applied, ConstraintsReturnAfterReopening) {
  Bench bench;
  bench.input.device_point_base_m = {0.003, 0, 0};
  bench.Set({Spring(200)});
  for (int i = 0; i < 200; ++i) bench.Tick();
  const Vec3 before = bench.output.force_base_N;
  EXPECT_NEAR(before.x, -0.6, 1e-9);
  bench.command.open = false;
  EXPECT_GT(bench.TicksToZero(), 0);
  bench.command.open = true;
  for (int i = 0; i < 200; ++i) bench.Tick();
  EXPECT_NEAR(bench.output.force_base_N.x, before.x, 1e-9);
}

// From one set to another, and to none: a tenth of the difference each tick, although the slew limit would allow 0.85
// N.
TEST(Applied, ConstraintChangesAreBlended) {
  Bench bench;
  bench.Set({Spring(400, {-0.002, 0, 0})});
  for (int i = 0; i < 300; ++i) bench.Tick();
  Vec3 last = bench.output.force_base_N;
  ASSERT_NEAR(last.x, -0.8, 1e-9);
  bench.Set({Spring(400, {0.001, 0, 0})});
  for (int i = 0; i < 12; ++i) {
    const Vec3 now = bench.Tick();
    EXPECT_LE(Norm(now - last), 0.13) << i;
    last = now;
  }
  EXPECT_NEAR(last.x, 0.4, 1e-9);
  bench.Set({});
  for (int i = 0; i < 12; ++i) {
    const Vec3 now = bench.Tick();
    EXPECT_LE(Norm(now - last), 0.13) << i;
    last = now;
  }
  EXPECT_EQ(last, Vec3{});
}

// A pen that is not seen for a while gets the force back if its time is not up, and never one whose time is.
TEST(Applied, ForceReturnsAfterTrackingLossOnlyIfNotExpired) {
  Bench bench;
  bench.Push({1, 0, 0}, 0.1);
  for (int i = 0; i < 30; ++i) bench.Tick();
  bench.input.tracked = false;
  for (int i = 0; i < 30; ++i) bench.Tick();
  EXPECT_EQ(bench.output.force_base_N, Vec3{});
  bench.input.tracked = true;
  for (int i = 0; i < 20; ++i) bench.Tick();
  EXPECT_NEAR(bench.output.force_base_N.x, 1, 1e-9);
  bench.input.tracked = false;
  for (int i = 0; i < 100; ++i) bench.Tick();
  bench.input.tracked = true;
  for (int i = 0; i < 20; ++i) EXPECT_EQ(bench.Tick(), Vec3{});
  bench.Push({0, 0.5, 0}, 0.1, 0.02);
  for (int i = 0; i < 40; ++i) EXPECT_EQ(bench.Tick().x, 0) << "nothing of the old one";
  EXPECT_NEAR(bench.output.force_base_N.y, 0.5, 1e-9);
}

// Random applications, hands and lost sight: never over the force limit, never faster than the slew limit, always a
// number.
TEST(Applied, ForceAndSlewStayBoundedForRandomRequests) {
  std::mt19937_64 random(7);
  const auto in = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  const auto vector = [&](double s) { return Vec3{in(-s, s), in(-s, s), in(-s, s)}; };
  const double nasty[] = {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 1e300, -1,
                          0};
  for (int run = 0; run < 40; ++run) {
    Bench bench;
    Vec3 last;
    Vec3 x = vector(0.03);
    Vec3 v;
    for (int tick = 0; tick < 1500; ++tick) {
      if (random() % 40 == 0) bench.Push(vector(4), in(0, 0.1), in(0, 0.1));
      if (random() % 60 == 0) {
        std::array<Constraint, 3> set;
        for (Constraint& c : set) {
          c.kind = static_cast<ConstraintKind>(1 + random() % kConstraintKinds);
          c.side = static_cast<ConstraintSide>(random() % 3);
          c.stiffness_N_m = in(0, 5000);
          c.damping_Ns_m = in(0, 20);
          c.max_force_N = in(0, 20);
          c.radius_m = in(0.001, 0.03);
          c.point_base_m = vector(0.03);
          c.velocity_base_m_s = random() % 2 == 0 ? Vec3{} : vector(0.5);
          if (random() % 10 == 0) c.stiffness_N_m = nasty[random() % 5];
          if (random() % 10 == 0) c.point_base_m.y = nasty[random() % 5];
        }
        bench.Set({set[0], set[1], set[2]});
      }
      if (random() % 200 == 0) bench.command.open = !bench.command.open;
      if (random() % 100 == 0) bench.input.tracked = !bench.input.tracked;
      if (random() % 300 == 0) bench.command.force_base_N.x = nasty[random() % 5];
      if (random() % 300 == 0) bench.input.bound.stiffness_N_m = nasty[random() % 5];
      if (random() % 300 == 0) bench.input.bound = Generous();
      v = v + 0.01 * vector(1);
      x = 0.999 * (x + kTick_s * v);
      bench.input.device_point_base_m = random() % 500 == 0 ? Vec3{nasty[random() % 5], 0, 0} : x;
      bench.input.velocity_base_m_s = v;
      const Vec3 force_N = bench.Tick();
      ASSERT_TRUE(IsWithin(force_N, 1e6)) << run << ' ' << tick;
      ASSERT_LE(Norm(force_N), bench.config.force_max_N * (1 + 1e-9));
      ASSERT_LE(Norm(force_N - last), bench.config.force_slew_N_s * kTick_s * (1 + 1e-9));
      last = force_N;
    }
  }
}

// What four random springs of the first so many kinds are together: the device point is moved a little, the force read.
struct Combined {
  double stiffness_N_m = 0;
  bool limited = false;
};
Combined CombineSprings(std::uint32_t kinds, std::mt19937_64& random) {
  const auto in = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(random); };
  constexpr double kFlat_m = 0.3;
  Bench bench;
  bench.input.device_point_base_m = {0.002, -0.001, 0.0015};
  std::array<Constraint, 4> set;
  for (Constraint& c : set) {
    c.kind = static_cast<ConstraintKind>(1 + random() % kinds);
    c.stiffness_N_m = in(100, 3000);
    c.max_force_N = 100;
    c.point_base_m = {in(-1e-3, 1e-3), in(-1e-3, 1e-3), in(-1e-3, 1e-3)};
    c.direction_base = Normalized(Vec3{in(-1, 1), in(-1, 1), in(0.1, 1)});
    if (c.kind == ConstraintKind::kSphere) {
      c.radius_m = kFlat_m;
      c.point_base_m = c.point_base_m + kFlat_m * c.direction_base;
    }
  }
  bench.config.force_max_N = 1e3;
  bench.Set({set[0], set[1], set[2], set[3]});
  for (int i = 0; i < 1500; ++i) bench.Tick();
  const Vec3 x = bench.input.device_point_base_m;
  const Vec3 direction = Normalized(Vec3{in(-1, 1), in(-1, 1), in(-1, 1)});
  bench.state.energy = {};
  const Vec3 before = bench.Tick();
  bench.input.device_point_base_m = x + 1e-5 * direction;
  const Vec3 after = bench.Tick();
  return {-Dot(after - before, direction) / 1e-5, bench.output.stiffness_limited};
}

// Springs in all directions together stay within the stiffness bound.
TEST(Applied, CombinedSpringsStayWithinTheStiffnessBound) {
  std::mt19937_64 random(8);
  for (int run = 0; run < 60; ++run) {
    const Combined combined = CombineSprings(3, random);
    EXPECT_LE(combined.stiffness_N_m, 500 * 1.01) << "run " << run;
    EXPECT_GE(combined.stiffness_N_m, 0);
    EXPECT_TRUE(combined.limited);
  }
}

// Of a sphere around the point the sides push it on; syrup is no spring.
TEST(Applied, CombinedSpringsOfAnyKindStayWithinTheStiffnessBound) {
  std::mt19937_64 random(9);
  for (int run = 0; run < 60; ++run) {
    EXPECT_LE(CombineSprings(kConstraintKinds, random).stiffness_N_m, 500 * 1.01) << "run " << run;
  }
}

TEST(Applied, ContactsTakePrecedenceOverConstraints) {
  Bench bench;
  bench.input.device_point_base_m = {0, 0, -0.002};
  bench.Set({{.kind = ConstraintKind::kPlane, .stiffness_N_m = 500, .max_force_N = 5, .direction_base = {0, 0, 1}}});
  for (int i = 0; i < 300; ++i) bench.Tick();
  const double alone_N = bench.output.force_base_N.z;
  EXPECT_NEAR(alone_N, 1.0, 1e-6);
  Output contacts;
  contacts.contact_count = 1;
  contacts.contacts[0].normal_base = {0, 0, 1};
  contacts.contacts[0].load = 1;
  bench.input.contacts = &contacts;
  for (int i = 0; i < 300; ++i) bench.Tick();
  EXPECT_NEAR(bench.output.force_base_N.z, 0.25 * alone_N, 0.01);
  contacts.contacts[0].normal_base = {1, 0, 0};  // a wall beside: nothing to share
  for (int i = 0; i < 4000; ++i) bench.Tick();
  EXPECT_NEAR(bench.output.force_base_N.z, alone_N, 0.02);
}

// A hand on the spring, through sampling and delay: within the stiffness bound it comes to rest. `given_N_m`: the
// bound.
double SwingAfter2s_m(double given_N_m) {
  Bench bench;
  bench.input.bound.stiffness_N_m = bench.input.bound.along_N_m = given_N_m;
  bench.Set({Spring(1e5)});
  constexpr double kMass_kg = 0.1, kHandDamping_Ns_m = 1, kHandStiffness_N_m = 150, kStep_s = 1e-4;
  std::array<Vec3, 4> on_the_way{};
  double x = 0.002, v = 0, largest_m = 0;
  for (int tick = 0; tick < 2000; ++tick) {
    bench.input.device_point_base_m = {x, 0, 0};
    bench.input.velocity_base_m_s = {v, 0, 0};
    for (std::size_t i = on_the_way.size() - 1; i > 0; --i) on_the_way[i] = on_the_way[i - 1];
    on_the_way[0] = bench.Tick();
    bench.state.swing = {};  // the swing watch would reduce what exceeds the bound
    for (int k = 0; k < 10; ++k) {
      const double f = on_the_way.back().x - kHandDamping_Ns_m * v - kHandStiffness_N_m * x;
      v += kStep_s * f / kMass_kg;
      x += kStep_s * v;
    }
    if (tick > 1800) largest_m = std::max(largest_m, std::abs(x));
  }
  return largest_m;
}

TEST(Applied, StiffSpringUnderDelayComesToRest) {
  EXPECT_LT(SwingAfter2s_m(140), 2e-5);
  EXPECT_GT(SwingAfter2s_m(2000), 2e-4) << "without the limit it would not: this test can fail";
}

}  // namespace test_haptics_applied
}  // namespace omni::haptics
