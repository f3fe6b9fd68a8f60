// Plant and control core together, without USB, on the host and in the emulated Cortex-M7: boots, tests itself, arms,
// follows; every fault of the plant ends with the coils at zero.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <ostream>
#include <string>

#include "firmware/drivers/usb_descriptors.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/sim/coils/plant.h"
#include "tests/hil/board/tools.h"
#include "tests/hil/chain.h"
#include "tests/hil/fake_host.h"
#include "tests/hil/hil_board.h"

namespace omni::hil {
namespace {

constexpr double kZero_A = 0.02;
constexpr double kZeroWithin_ms = 20;

sim::PlantOptions Options() {
  sim::PlantOptions options;
  options.truth = config::IdealTwin();
  options.script.name = "holding";
  options.script.waypoints = {{0, {0, 0, 0.06}, {0, 0, -1}, true}};
  return options;
}

double Largest_A(const sim::Plant& plant) {
  double largest_A = 0;
  for (const double current_A : plant.current_A()) largest_A = std::max(largest_A, std::abs(current_A));
  return largest_A;
}

// A base that is armed and follows, on either board.
struct Scenario {
  explicit Scenario(const std::string& kind = "host") : plant(config::DefaultDevice(), Options()) {
    auto made = MakeBoard(kind);
    if (!made) {
      ADD_FAILURE() << made.error();
      return;
    }
    board = std::move(*made);
    chain = std::make_unique<Chain>(plant, *board);
    host = std::make_unique<FakeHost>(*chain);
  }
  void ArmAndFollow(const std::array<float, 3>& set_point_A, int ticks = 200) {
    ASSERT_TRUE(host->WaitFor(wire::State::kIdle, 3000))
        << static_cast<int>(chain->telemetry().state) << " faults " << chain->telemetry().faults;
    ASSERT_TRUE(host->Arm()) << "faults " << chain->telemetry().faults;
    host->Run(ticks, set_point_A);
    ASSERT_EQ(chain->telemetry().faults, 0U);
  }
  // Milliseconds until all coils are at zero for good, with the host still commanding.
  double ZeroAfter_ms(const std::array<float, 3>& set_point_A, int ticks = 100) {
    double zero_ms = 0;
    for (int i = 1; i <= ticks; ++i) {
      host->Run(1, set_point_A);
      if (Largest_A(plant) > kZero_A) zero_ms = i;
    }
    return zero_ms;
  }

  sim::Plant plant;
  std::unique_ptr<HilBoard> board;
  std::unique_ptr<Chain> chain;
  std::unique_ptr<FakeHost> host;
};

constexpr std::array<float, 3> kSome_A{1.5F, -2.0F, 3.0F};

TEST(HilChain, BootsArmsAndFollowsSetPoints) {
  Scenario scenario;
  ASSERT_NO_FATAL_FAILURE(scenario.ArmAndFollow(kSome_A, 300));
  for (std::size_t k = 0; k < 3; ++k) {
    // The current sensor's own error: 0.15 % and 2 mA, three sigma of both.
    const double allowed_A = 0.006 + 0.01 * std::abs(kSome_A[k]);
    EXPECT_NEAR(scenario.plant.current_A()[k], kSome_A[k], allowed_A) << k;
  }
}

// The same plant and the same frames: the board in QEMU does what the core on the host does, bit by bit.
TEST(HilChain, EmulatedBoardMatchesTheHostBoardExactly) {
  const std::string reason = NoBoardReason();
  if (!reason.empty()) GTEST_SKIP() << reason;
  Scenario host;
  Scenario qemu("qemu");
  ASSERT_NE(qemu.chain, nullptr);
  ASSERT_NO_FATAL_FAILURE(host.ArmAndFollow(kSome_A));
  ASSERT_NO_FATAL_FAILURE(qemu.ArmAndFollow(kSome_A));
  EXPECT_EQ(host.plant.now_ns(), qemu.plant.now_ns());
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(host.plant.current_A()[k], qemu.plant.current_A()[k]) << k;
  EXPECT_EQ(host.plant.pose().centre_base_m.z, qemu.plant.pose().centre_base_m.z);
}

TEST(HilChain, HostSilenceEndsInZeroCurrent) {
  Scenario scenario;
  ASSERT_NO_FATAL_FAILURE(scenario.ArmAndFollow(kSome_A));
  double zero_ms = 0;
  for (int i = 1; i <= 100; ++i) {
    scenario.host->Run(1);
    if (Largest_A(scenario.plant) > kZero_A) zero_ms = i;
  }
  RecordProperty("zero_ms", std::to_string(zero_ms));
  EXPECT_LE(zero_ms, 20) << "time to live, then a ramp of at most 5 ms";
  EXPECT_NE(scenario.chain->telemetry().faults & wire::kFaultHostSilent, 0U);
  EXPECT_TRUE(scenario.host->Arm()) << "the host's own faults do not require a check by the user";
}

struct FaultCase {
  const char* name;
  wire::Fault fault;
  double zero_within_ms;  // from the cause; longer for faults that take time to detect
  void (*apply)(sim::PlantFaults&);
};

void PrintTo(const FaultCase& fault, std::ostream* out) { *out << fault.name; }

class HilFault : public testing::TestWithParam<FaultCase> {};

TEST_P(HilFault, EndsInZeroCurrentAndStaysLatched) {
  Scenario scenario;
  ASSERT_NO_FATAL_FAILURE(scenario.ArmAndFollow(kSome_A));
  GetParam().apply(scenario.plant.faults());
  const double zero_ms = scenario.ZeroAfter_ms(kSome_A, 400);
  RecordProperty("zero_ms", std::to_string(zero_ms));
  std::printf("%-24s zero after %5.0f ms, faults %05x\n", GetParam().name, zero_ms, scenario.chain->telemetry().faults);
  EXPECT_NE(scenario.chain->telemetry().faults & GetParam().fault, 0U)
      << std::hex << scenario.chain->telemetry().faults;
  EXPECT_LE(zero_ms, GetParam().zero_within_ms);
  EXPECT_LE(scenario.plant.supply_V(), 28) << "brake before sleep";
  scenario.plant.faults() = {};
  EXPECT_LE(scenario.ZeroAfter_ms(kSome_A, 100), 0) << "latched, although its cause is gone";
}

INSTANTIATE_TEST_SUITE_P(
    Plant, HilFault,
    testing::Values(
        FaultCase{"emergency_stop", wire::kFaultEmergencyStop, kZeroWithin_ms,
                  [](sim::PlantFaults& faults) { faults.emergency_stop = true; }},
        FaultCase{"hall_stuck", wire::kFaultHallStuck, 60,
                  [](sim::PlantFaults& faults) { faults.hall[2] = sim::HallFault::kStuck; }},
        FaultCase{"hall_stopped", wire::kFaultHallSensor, 60,
                  [](sim::PlantFaults& faults) { faults.hall[2] = sim::HallFault::kStopped; }},
        FaultCase{"hall_dead", wire::kFaultHallSensor, 60,
                  [](sim::PlantFaults& faults) { faults.hall[2] = sim::HallFault::kDead; }},
        FaultCase{"hall_identity", wire::kFaultHallSensor, 60,
                  [](sim::PlantFaults& faults) { faults.hall[2] = sim::HallFault::kWrongIdentity; }},
        FaultCase{"current_sensor", wire::kFaultCurrentSensor, kZeroWithin_ms,
                  [](sim::PlantFaults& faults) { faults.current_sensor_dead[1] = true; }},
        FaultCase{"bridge", wire::kFaultDriver, kZeroWithin_ms,
                  [](sim::PlantFaults& faults) { faults.bridge[1] = true; }},
        FaultCase{"coil_open", wire::kFaultCoilOpen, 40, [](sim::PlantFaults& faults) { faults.coil_open[2] = true; }},
        FaultCase{"supply_low", wire::kFaultSupplyLow, 40, [](sim::PlantFaults& faults) { faults.supply_V = 8; }},
        FaultCase{"supply_high", wire::kFaultSupplyHigh, 40, [](sim::PlantFaults& faults) { faults.supply_V = 27; }}),
    [](const auto& fault) { return std::string(fault.param.name); });

// Current shrinks from 60 C on; below 1 A the resistance cannot be measured any more, but that current heats nothing.
TEST(HilChain, ExternalHeatIsMeasuredByResistanceAndDerates) {
  constexpr std::array<float, 3> kMuch_A{0, 0, 8};
  Scenario scenario;
  ASSERT_NO_FATAL_FAILURE(scenario.ArmAndFollow(kMuch_A));
  scenario.plant.faults().extra_heat_W = {0, 0, 300};
  double warm_A = 0, hot_A = 0;
  for (int i = 0; i < 10000 && scenario.plant.temperature_C()[2] < 80; ++i) {
    scenario.host->Run(1, kMuch_A);
    const double current_A = std::abs(scenario.plant.current_A()[2]);
    if (scenario.plant.temperature_C()[2] < 55) warm_A = current_A;
    if (scenario.plant.temperature_C()[2] > 75) hot_A = std::max(hot_A, current_A);
  }
  EXPECT_GT(scenario.plant.temperature_C()[2], 75);
  EXPECT_GT(warm_A, 7.9);
  EXPECT_LT(hot_A, 1.05);
}

TEST(HilChain, EndpointZeroServesHelloAndEmergencyStop) {
  Scenario scenario;
  ASSERT_NO_FATAL_FAILURE(scenario.ArmAndFollow(kSome_A));
  std::uint8_t answer[wire::kFrameSizeMax];
  const int size = scenario.chain->VendorRequest(drivers::usb::kRequestHello, 0, 0, answer, sizeof answer);
  wire::FrameView view;
  wire::Hello hello;
  ASSERT_EQ(wire::OpenFrame(answer, static_cast<std::size_t>(size), view), wire::Status::kOk);
  EXPECT_EQ(wire::Decode(view, hello), wire::Status::kOk);
  EXPECT_EQ(scenario.chain->VendorRequest(99, 0, 0, answer, sizeof answer), -1);
  EXPECT_EQ(scenario.chain->VendorRequest(drivers::usb::kRequestEstop, 3, 0, answer, sizeof answer), 0);
  EXPECT_LE(scenario.ZeroAfter_ms(kSome_A), kZeroWithin_ms);
  EXPECT_NE(scenario.chain->telemetry().faults & wire::kFaultEmergencyStop, 0U);
}

TEST(HilChain, ResetRestartsTheBaseAtZeroCurrent) {
  Scenario scenario;
  ASSERT_NO_FATAL_FAILURE(scenario.ArmAndFollow(kSome_A));
  ASSERT_TRUE(scenario.chain->Reset(firmware::ResetCause::kSoftware).ok());
  EXPECT_LE(scenario.ZeroAfter_ms(kSome_A), kZeroWithin_ms + 1000) << "the self-test drives about an ampere";
  EXPECT_TRUE(scenario.host->WaitFor(wire::State::kIdle, 3000));
  EXPECT_LT(Largest_A(scenario.plant), kZero_A);
}

}  // namespace
}  // namespace omni::hil
