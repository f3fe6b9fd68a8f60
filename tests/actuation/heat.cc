// The host's heat model: energy balance, the paper's runs, derating that never lets the copper pass its limit and never
// makes a noticeable step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "service/actuation/actuation.h"
#include "service/sim/coils/coil_bank.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::actuation {
namespace test_actuation_heat {

using Currents = std::array<double, base::kCoilCount>;
constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

HeatConfig Nominal() { return MakeHeatConfig(support::NominalDevice()); }

HeatState StateAt(double temperature_C) {
  HeatState state;
  state.started = true;
  state.copper_C.fill(temperature_C);
  state.body_C = temperature_C;
  return state;
}

base::HallScan ScanAt(std::int64_t t_ns, const Currents& current_A, double temperature_C) {
  base::HallScan scan;
  scan.t_ns = t_ns;
  scan.coil_current_A = current_A;
  scan.coil_temperature_C.fill(temperature_C);
  scan.supply_V = 18;
  return scan;
}

TEST(ActuationHeat, EnergyIsConserved) {
  support::Rng rng(31);
  const HeatConfig config = Nominal();
  HeatState state = StateAt(30);
  double stored_J = 0, in_J = 0;
  for (int i = 0; i < 20'000; ++i) {
    Currents current_A{};
    for (double& current : current_A) current = support::Uniform(rng, -15, 15);
    const double dt_s = support::Uniform(rng, 1e-4, 1e-2);
    for (std::size_t k = 0; k < 3; ++k) {
      const double ohm = config.resistance_20C_ohm[k] * (1 + kCopperPerKelvin * (state.copper_C[k] - 20));
      in_J += current_A[k] * current_A[k] * ohm * dt_s;
    }
    in_J -= config.nodes.body_to_air_W_K * (state.body_C - config.nodes.air_C) * dt_s;
    const HeatState before = state;
    AdvanceHeat(config, current_A, dt_s, state);
    for (std::size_t k = 0; k < 3; ++k) stored_J += config.nodes.copper_J_K * (state.copper_C[k] - before.copper_C[k]);
    stored_J += config.nodes.body_J_K * (state.body_C - before.body_C);
  }
  EXPECT_GT(in_J, 1000);
  EXPECT_NEAR(stored_J, in_J, 1e-9 * in_J);
}

// Steady state of one coil: Tc - Tb = P / Gcb, Tb - Ta = P / Gba.
TEST(ActuationHeat, SteadyStateBalancesHeatFlows) {
  const HeatConfig config = Nominal();
  HeatState state = StateAt(24);
  for (int i = 0; i < 100'000; ++i) AdvanceHeat(config, {0, 5, 0}, 0.1, state);
  const double power_W = 25 * config.resistance_20C_ohm[1] * (1 + kCopperPerKelvin * (state.copper_C[1] - 20));
  EXPECT_NEAR(state.copper_C[1] - state.body_C, power_W / config.nodes.copper_to_body_W_K, 1e-6);
  EXPECT_NEAR(state.body_C - 24, power_W / config.nodes.body_to_air_W_K, 1e-6);
  EXPECT_NEAR(state.copper_C[0], state.body_C, 1e-6);
}

// 15 A for 25 s, then off: body 39 C at 65 s, while the copper has been far hotter. 5 A for 15 min: 47 C.
TEST(ActuationHeat, MatchesThePublishedHeatingRuns) {
  const HeatConfig config = Nominal();
  HeatState state = StateAt(24);
  double body_peak_C = 0, peak_s = 0, copper_peak_C = 0;
  for (int i = 0; i < 200'000; ++i) {
    const double t_s = i * 1e-3;
    AdvanceHeat(config, {0, t_s < 25 ? 15.0 : 0.0, 0}, 1e-3, state);
    copper_peak_C = std::max(copper_peak_C, state.copper_C[1]);
    if (state.body_C > body_peak_C) body_peak_C = state.body_C, peak_s = t_s;
  }
  EXPECT_NEAR(body_peak_C, 39, 0.1);
  EXPECT_NEAR(peak_s, 65, 1);
  EXPECT_GT(copper_peak_C, 90);
  state = StateAt(24);
  for (int i = 0; i < 900'000; ++i) AdvanceHeat(config, {0, 5, 0}, 1e-3, state);
  EXPECT_NEAR(state.body_C, 47, 0.1);
}

// Full current on all coils for a quarter of an hour, real coils nominal or 15 % worse than the model in everything.
struct Derated {
  double copper_max_C = 0, step_max_A = 0, current_end_A = 0;
};
Derated RunDerated(double worse, bool device_reports) {
  const base::DeviceGeometry device = support::NominalDevice();
  const Config config = MakeConfig(device);
  sim::ThermalConfig thermal;
  thermal.copper_J_K = device.heat.copper_J_K / worse;
  thermal.body_J_K = device.heat.body_J_K / worse;
  thermal.copper_to_body_W_K = device.heat.copper_to_body_W_K / worse;
  thermal.body_to_air_W_K = device.heat.body_to_air_W_K / worse;
  sim::CoilBank coils(device, thermal);
  State state;
  Derated derated;
  constexpr std::int64_t kStep_ns = 2'000'000;
  for (std::int64_t i = 0; i < 450'000; ++i) {
    base::HallScan scan = ScanAt(i * kStep_ns, coils.current_A(), 24);
    if (device_reports) scan.coil_temperature_C = coils.temperature_C();
    const Currents before = state.heat.current_max_A;
    UpdateHeat(config, scan, state);
    state.last_current_A = state.heat.current_max_A;
    if (i > 0) {
      for (std::size_t k = 0; k < 3; ++k) {
        derated.step_max_A = std::max(derated.step_max_A, std::abs(state.heat.current_max_A[k] - before[k]));
      }
    }
    coils.SetCurrents(state.heat.current_max_A);
    coils.StepHeat(2e-3);
    derated.copper_max_C =
        std::max(derated.copper_max_C, *std::max_element(coils.temperature_C().begin(), coils.temperature_C().end()));
    derated.current_end_A = coils.current_A()[1];
  }
  return derated;
}

TEST(ActuationHeat, CopperStaysBelowItsLimitUnderFullLoad) {
  const Derated blind = RunDerated(1, false);
  EXPECT_LT(blind.copper_max_C, 68);
  EXPECT_GT(blind.copper_max_C, 66) << "what is there may be used";
  EXPECT_GT(blind.current_end_A, 3);
  EXPECT_LT(blind.step_max_A, 0.01) << "per 2 ms: less than 2.5 mN";
  const Derated reported = RunDerated(1.15, true);
  EXPECT_LT(reported.copper_max_C, 70);
  EXPECT_LT(reported.step_max_A, 0.02);
}

TEST(ActuationHeat, CurrentCeilingsChangeWithoutSteps) {
  const HeatConfig config = Nominal();
  HeatState state;
  std::int64_t t_ns = 0;
  const auto step = [&](double temperature_C) {
    const Currents before = state.current_max_A;
    UpdateHeat(config, ScanAt(t_ns += 1'000'000, {}, temperature_C), {}, state);
    for (std::size_t k = 0; k < 3; ++k) {
      EXPECT_LE(before[k] - state.current_max_A[k], config.fall_A_s * 1e-3 + 1e-12);
      EXPECT_LE(state.current_max_A[k] - before[k], config.rise_A_s * 1e-3 + 1e-12);
      EXPECT_GE(state.current_max_A[k], 0);
      EXPECT_LE(state.current_max_A[k], config.current_max_A);
    }
  };
  UpdateHeat(config, ScanAt(0, {}, 25), {}, state);
  EXPECT_DOUBLE_EQ(state.current_max_A[0], 15);
  for (int i = 0; i < 100; ++i) step(25);
  for (int i = 0; i < 100; ++i) step(kNaN);  // no temperature: down to zero within 50 ms
  EXPECT_EQ(state.current_max_A[0], 0);
  for (int i = 0; i < 2000; ++i) step(25);
  EXPECT_DOUBLE_EQ(state.current_max_A[0], 15);
  for (int i = 0; i < 2000; ++i) step(1e30);
  EXPECT_EQ(state.current_max_A[2], 0);
}

TEST(ActuationHeat, CeilingFallsMonotonicallyWithCopperTemperature) {
  const HeatConfig config = Nominal();
  for (const double body_C : {24.0, 45.0, 60.0}) {
    double last_A = CurrentCeiling_A(config, 1, body_C, body_C);
    EXPECT_GT(last_A, 5);
    const int steps = static_cast<int>((75 - body_C) / 0.05);
    for (int step = 0; step <= steps; ++step) {
      const double copper_C = body_C + 0.05 * step;
      const double now_A = CurrentCeiling_A(config, 1, copper_C, body_C);
      EXPECT_LE(now_A, last_A + 1e-12);
      EXPECT_LT(last_A - now_A, 0.3) << copper_C << " C over a body of " << body_C << " C";
      last_A = now_A;
    }
    EXPECT_EQ(last_A, 0);
  }
  EXPECT_EQ(CurrentCeiling_A(config, 0, kNaN, 30), 0);
  EXPECT_EQ(CurrentCeiling_A(config, 0, 30, kNaN), 0);
}

TEST(ActuationHeat, SupplyLimitsTheCurrent) {
  HeatConfig config = Nominal();
  config.supply_V = 6;
  const double ohm = config.resistance_20C_ohm[2] * (1 + kCopperPerKelvin * 10);
  EXPECT_NEAR(CurrentCeiling_A(config, 2, 30, 30), 6 / ohm, 1e-12);
}

TEST(ActuationHeat, UsesTheWarmerOfModelAndDevice) {
  const HeatConfig config = Nominal();
  HeatState state;
  UpdateHeat(config, ScanAt(0, {}, 50), {}, state);  // after a restart: the body may be as warm
  EXPECT_EQ(state.body_C, 50);
  for (std::int64_t i = 1; i <= 2000; ++i) UpdateHeat(config, ScanAt(i * 1'000'000, {}, 60), {}, state);
  EXPECT_NEAR(state.copper_C[0], 60, 0.5);
  EXPECT_LT(state.current_max_A[0], 12);
  HeatState cool = StateAt(24);
  for (std::int64_t i = 1; i <= 10'000; ++i) UpdateHeat(config, ScanAt(i * 1'000'000, {0, 15, 0}, 24), {}, cool);
  EXPECT_GT(cool.copper_C[1], 45) << "a device that reports the body does not hide the copper";
}

// Whatever a broken scan contains: the state stays finite and inside its limits.
TEST(ActuationHeat, AnyScanLeavesAFiniteState) {
  support::Rng rng(32);
  const HeatConfig config = Nominal();
  HeatState state;
  std::int64_t t_ns = 0;
  const double values[] = {kNaN, std::numeric_limits<double>::infinity(), -1e308, 1e308, -300, 0, 25, 80, 15};
  const auto any = [&] { return values[rng() % 9]; };
  for (int i = 0; i < 50'000; ++i) {
    base::HallScan scan;
    t_ns += static_cast<std::int64_t>(rng() % 4'000'000) - 1'000'000;
    scan.t_ns = rng() % 50 == 0 ? static_cast<std::int64_t>(rng() >> 2) : t_ns;
    scan.coil_current_A = {any(), any(), any()};
    scan.coil_temperature_C = {any(), any(), any()};
    scan.supply_V = any();
    UpdateHeat(config, scan, {any(), any(), any()}, state);
    ASSERT_TRUE(std::isfinite(state.body_C));
    for (std::size_t k = 0; k < 3; ++k) {
      ASSERT_TRUE(std::isfinite(state.copper_C[k]));
      ASSERT_GE(state.current_max_A[k], 0);
      ASSERT_LE(state.current_max_A[k], config.current_max_A);
    }
  }
}

}  // namespace test_actuation_heat
}  // namespace omni::actuation
