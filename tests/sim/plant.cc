// The physical side of a base for a firmware core: bridges, coils, supply, sensors, pen; and everything that breaks.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

#include "firmware/wire/messages.h"
#include "service/sim/coils/plant.h"
#include "tests/support/rig/twin_scenario.h"

namespace omni::sim {
namespace test_sim_plant {

using firmware::Inputs;
using firmware::Outputs;
using support::Holding;
using support::NominalDevice;

constexpr double kStep_s = 250e-6;
constexpr std::uint8_t kAllAwake = 0b111;

PlantOptions Perfect(const HandScript& script = {}) {
  PlantOptions options;
  options.script = script;
  options.imperfect = false;
  return options;
}

Outputs Duty(double x, double y, double z, std::uint8_t awake = kAllAwake) {
  Outputs outputs;
  outputs.duty[0] = static_cast<std::int16_t>(std::lround(x * wire::kDutyFull));
  outputs.duty[1] = static_cast<std::int16_t>(std::lround(y * wire::kDutyFull));
  outputs.duty[2] = static_cast<std::int16_t>(std::lround(z * wire::kDutyFull));
  outputs.awake = awake;
  return outputs;
}

struct Scenario {
  explicit Scenario(const PlantOptions& options = Perfect()) : plant(NominalDevice(), options) {}
  const Inputs& Run(const Outputs& outputs, int steps) {
    for (int i = 0; i < steps; ++i) plant.Step(outputs);
    return plant.inputs();
  }
  double Measured_A(std::size_t k) const { return plant.inputs().current[k] * wire::kCurrentUnit_A; }

  Plant plant;
};

TEST(SimPlant, CurrentRisesWithTheCoilsOwnTimeConstant) {
  Scenario scenario;
  const double resistance = 0.633 * (1 + 0.00393 * 4) + BridgeParameters{}.on_ohm;
  const double tau_s = 1.1e-3 / resistance;
  const Outputs outputs = Duty(0.25, 0, 0);
  double last_A = 0;
  for (int i = 1; i <= 12; ++i) {
    scenario.plant.Step(outputs);
    const double supply_V = scenario.plant.supply_V();
    const double final_A = 0.25 * supply_V / resistance;
    const double now_A = scenario.plant.current_A()[0];
    ASSERT_NEAR(now_A, final_A * (1 - std::exp(-i * kStep_s / tau_s)), 0.03 * final_A) << i;
    EXPECT_GT(scenario.Measured_A(0), last_A) << "the mean over a step lies between its ends";
    EXPECT_LT(scenario.Measured_A(0), now_A);
    last_A = now_A;
  }
  EXPECT_EQ(scenario.plant.current_A()[1], 0);
}

TEST(SimPlant, CurrentSensorsApplyTheirErrorsAndUnits) {
  PlantOptions options = Perfect();
  options.imperfect = true;
  options.truth.imperfections = NoImperfections();
  options.truth.imperfections.current_gain = 0.01;
  options.truth.imperfections.current_offset_A = 0.05;
  Scenario scenario(options);
  Scenario perfect;
  const Outputs outputs = Duty(0.2, 0.2, 0.2);
  scenario.Run(outputs, 100);
  perfect.Run(outputs, 100);
  for (std::size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(perfect.Measured_A(k), perfect.plant.current_A()[k], 2e-3);
    EXPECT_GT(std::abs(scenario.Measured_A(k) - scenario.plant.current_A()[k]), 2e-3) << k;
    const double voltage_V = perfect.plant.inputs().voltage[k] * wire::kSupplyUnit_V;
    EXPECT_NEAR(voltage_V / perfect.plant.current_A()[k], NominalDevice().coils[k].resistance_20C_ohm * 1.0157, 5e-3);
  }
}

TEST(SimPlant, SupplySagsUnderLoadAndIsPumpedUpByCoastingCoils) {
  Scenario scenario;
  scenario.Run(Duty(0.6, -0.6, 0.6), 200);
  EXPECT_LT(scenario.plant.supply_V(), 18 - 0.05 * 15) << "three coils draw more than 15 A from it";
  const CoilArray before_A = scenario.plant.current_A();
  double highest_V = 0;
  for (int i = 0; i < 12; ++i) {
    scenario.Run(Duty(0, 0, 0, 0), 1);
    highest_V = std::max(highest_V, scenario.plant.supply_V());
  }
  EXPECT_EQ(scenario.plant.current_A(), CoilArray{}) << "against the supply, 3 ms are enough";
  double energy_J = 0;
  for (const double current_A : before_A) energy_J += 0.5 * 1.1e-3 * current_A * current_A;
  EXPECT_GT(highest_V, 20) << energy_J << " J have nowhere else to go";
  EXPECT_LT(0.5 * 1e-3 * (highest_V * highest_V - 18 * 18), energy_J) << "no more than was in the coils";
}

TEST(SimPlant, BrakingCoilsDoNotRaiseTheSupply) {
  Scenario scenario;
  scenario.Run(Duty(0.6, -0.6, 0.6), 200);
  double highest_V = 0;
  for (int i = 0; i < 80; ++i) {
    scenario.Run(Duty(0, 0, 0), 1);
    highest_V = std::max(highest_V, scenario.plant.supply_V());
  }
  EXPECT_LE(highest_V, 18);
  for (const double current_A : scenario.plant.current_A()) EXPECT_LT(std::abs(current_A), 0.01);
}

TEST(SimPlant, EverySensorHasItsOwnClock) {
  Scenario scenario(Perfect(Holding({0, 0, 0.06})));
  EXPECT_EQ(scenario.plant.inputs().field_age_us[0], 65535) << "no sample yet";
  std::array<int, base::kSensorCount> fresh{};
  for (int i = 0; i < 4000; ++i) {
    const Inputs& inputs = scenario.plant.Step({});
    for (std::size_t s = 0; s < fresh.size(); ++s) {
      fresh[s] += (inputs.field_fresh >> s) & 1;
      if (i >= 8) {
        ASSERT_LE(inputs.field_age_us[s], 1006) << s;
      }
    }
  }
  const auto [least, most] = std::minmax_element(fresh.begin(), fresh.end());
  EXPECT_GE(*least, 994);
  EXPECT_LE(*most, 1006);
  EXPECT_NE(*least, *most);
  EXPECT_EQ(scenario.plant.inputs().now_us, 1'000'000U);
}

TEST(SimPlant, CurrentsMoveThePen) {
  Scenario still(Perfect(Holding({0, 0, 0.05})));
  Scenario pushed(Perfect(Holding({0, 0, 0.05})));
  still.Run({}, 2000);
  pushed.Run(Duty(0, 0, 0.2), 2000);
  const double moved_m = pushed.plant.pose().centre_base_m.z - still.plant.pose().centre_base_m.z;
  EXPECT_GT(std::abs(moved_m), 1e-3);
  const TruthRow row = pushed.plant.Truth({.set_point_A = {1, 2, 3}, .command_age_s = 0.5, .faults = 7}, 1000);
  EXPECT_EQ(row.t_ns, 500'000'000 + 1000);
  EXPECT_EQ(row.current_A.z, pushed.plant.current_A()[2]);
  EXPECT_EQ(row.set_point_A.y, 2);
  EXPECT_EQ(row.faults, 7U);
  EXPECT_GT(std::abs(row.coil_force_N.z), 0.1);
}

// Up to what is reserved, where padding begins.
bool Same(const Inputs& a, const Inputs& b) { return std::memcmp(&a, &b, offsetof(Inputs, reserved)) == 0; }

TEST(SimPlant, EqualInputsGiveBitIdenticalReadings) {
  PlantOptions options;
  options.script = Holding({0.01, 0, 0.05});
  Scenario a(options);
  Scenario b(options);
  options.seed = 2;
  Scenario other(options);
  bool differs = false;
  for (int i = 0; i < 400; ++i) {
    const Outputs outputs = Duty(0.1 * std::sin(0.1 * i), 0.2, -0.1, i % 100 < 90 ? kAllAwake : 0);
    const Inputs& inputs = a.plant.Step(outputs);
    ASSERT_TRUE(Same(inputs, b.plant.Step(outputs))) << i;
    differs = !Same(inputs, other.plant.Step(outputs)) || differs;
  }
  EXPECT_TRUE(differs);
}

TEST(SimPlant, ResetClockResetsOnlyTheControllersClock) {
  Scenario scenario(Perfect(Holding({0, 0, 0.05})));
  scenario.Run(Duty(0.1, 0, 0), 100);
  const double current_A = scenario.plant.current_A()[0];
  scenario.plant.ResetClock();
  EXPECT_EQ(scenario.plant.inputs().now_us, 0U);
  EXPECT_EQ(scenario.plant.current_A()[0], current_A);
  scenario.Run({}, 1);
  EXPECT_EQ(scenario.plant.inputs().now_us, 250U);
}

TEST(SimPlant, SelfTestFieldReachesEverySensor) {
  Scenario scenario;
  scenario.Run({}, 20);
  const Inputs before = scenario.plant.inputs();
  Outputs outputs;
  outputs.hall_self_test = 1;
  for (int i = 0; i < 3; ++i) scenario.plant.Step(outputs);
  for (std::size_t s = 0; s < base::kSensorCount; ++s) {
    EXPECT_NEAR(scenario.plant.inputs().field[s][0] - before.field[s][0], 2e-4 * 17110000, 100) << "once, not per step";
    EXPECT_NEAR(scenario.plant.inputs().field[s][2] - before.field[s][2], 0.5e-4 * 17110000, 100);
  }
}

TEST(SimPlantFaults, HallSensorFaultsAffectReadingsAndAnswers) {
  Scenario scenario(Perfect(Holding({0, 0, 0.05})));
  scenario.Run({}, 40);
  const Inputs before = scenario.plant.inputs();
  auto& hall = scenario.plant.faults().hall;
  hall[0] = HallFault::kStuck;
  hall[1] = HallFault::kStopped;
  hall[2] = HallFault::kDead;
  hall[3] = HallFault::kWrongIdentity;
  std::array<int, 5> fresh{};
  int changed = 0;
  for (int i = 0; i < 80; ++i) {
    const Inputs& now = scenario.plant.Step({});
    for (std::size_t s = 0; s < fresh.size(); ++s) fresh[s] += (now.field_fresh >> s) & 1;
    changed += std::memcmp(now.field[0], before.field[0], sizeof now.field[0]) != 0;
  }
  const Inputs& now = scenario.plant.inputs();
  EXPECT_EQ(changed, 0);
  EXPECT_NEAR(fresh[0], 20, 1) << "a stuck sensor says that it is well";
  EXPECT_EQ(fresh[1], 0);
  EXPECT_GE(now.field_age_us[1], 20'000);
  EXPECT_EQ(fresh[2], 0);
  EXPECT_EQ(now.field_answers, 0b11110011);
  EXPECT_NEAR(fresh[4], 20, 1);
  hall = {};
  scenario.Run({}, 8);
  EXPECT_EQ(scenario.plant.inputs().field_answers, 0xFF);
  EXPECT_LE(scenario.plant.inputs().field_age_us[1], 1006);
}

TEST(SimPlantFaults, CoilBridgeAndCurrentSensorFaultsTakeEffect) {
  Scenario scenario;
  const Outputs outputs = Duty(0.1, 0.1, 0.1);
  scenario.Run(outputs, 100);
  const Inputs before = scenario.plant.inputs();
  PlantFaults& faults = scenario.plant.faults();
  faults.coil_open[0] = true;
  faults.current_sensor_dead[1] = true;
  faults.bridge[2] = true;
  scenario.Run(Duty(0.1, 0.3, 0.1), 20);
  EXPECT_EQ(scenario.Measured_A(0), 0);
  EXPECT_NEAR(scenario.plant.inputs().voltage[0] * wire::kSupplyUnit_V, 1.8, 0.1) << "voltage but no current";
  EXPECT_EQ(scenario.plant.inputs().current[1], before.current[1]) << "the old word, although the current has changed";
  EXPECT_EQ(scenario.plant.inputs().current_answers, 0b101);
  EXPECT_EQ(scenario.plant.inputs().driver_fault, 0b100);
  EXPECT_EQ(scenario.plant.current_A()[2], 0) << "a failed bridge coasts";
  faults = {};
  faults.coil_shorted[0] = true;
  scenario.Run(outputs, 4);
  EXPECT_GT(scenario.Measured_A(0), 20);
}

TEST(SimPlantFaults, SupplyFanEmergencyStopAndHeatFaultsTakeEffect) {
  Scenario scenario;
  Outputs outputs;
  outputs.fan = 255;
  scenario.Run(outputs, 20000);
  EXPECT_GT(scenario.plant.inputs().fan_rpm, 2900);
  EXPECT_EQ(scenario.plant.inputs().emergency_stop, 0);
  PlantFaults& faults = scenario.plant.faults();
  faults.supply_V = 9;
  faults.fan_stands = true;
  faults.emergency_stop = true;
  faults.extra_heat_W = {0, 500, 0};
  scenario.Run(outputs, 4000);
  EXPECT_EQ(scenario.plant.inputs().fan_rpm, 0);
  EXPECT_EQ(scenario.plant.inputs().emergency_stop, 1);
  EXPECT_NEAR(scenario.plant.temperature_C()[1], 24 + 500 / 44.4, 0.5);
  EXPECT_NEAR(scenario.plant.temperature_C()[0], 24, 0.5);
  EXPECT_LT(scenario.plant.supply_V(), 18);
  faults.supply_V = 25;
  scenario.Run(outputs, 4);
  EXPECT_NEAR(scenario.plant.inputs().supply * wire::kSupplyUnit_V, 25, 0.1);
}

// Outputs that no working core produces do no more than full duty.
TEST(SimPlantFaults, OutOfRangeOutputsStayWithinTheSupply) {
  Scenario scenario;
  Outputs outputs = Duty(0, 0, 0, 0xFF);
  for (std::int16_t& duty : outputs.duty) duty = std::numeric_limits<std::int16_t>::min();
  scenario.Run(outputs, 400);
  for (std::size_t k = 0; k < 3; ++k) EXPECT_GE(scenario.plant.current_A()[k], -18 / 0.633);
}

}  // namespace test_sim_plant
}  // namespace omni::sim
