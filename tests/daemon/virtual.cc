// Equal seed, script and scene give equal bits of every tick; anything else changes the hash.
#include <gtest/gtest.h>

#include "service/daemon/virtual_run.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {
namespace test_daemon_virtual {

daemon::VirtualRunSummary RunSeed(std::uint64_t seed, bool flip_coil_sign = false, double top_m = kTableTop_m) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const auto twin =
      sim::MakeVirtualTwin(device, {.seed = seed, .script = PressAndSlide(), .flip_coil_sign = flip_coil_sign}, 2.5);
  return daemon::RunVirtual(loop::MakeTickConfig(device), *twin, TableScene(top_m));
}

TEST(VirtualRun, EqualInputsGiveEqualBits) {
  const daemon::VirtualRunSummary first = RunSeed(7);
  EXPECT_EQ(first.ticks, 2500U);
  EXPECT_GT(first.contact_ticks, 500U);
  EXPECT_EQ(first.hash, RunSeed(7).hash);
}

TEST(VirtualRun, HashDependsOnSeedCoilSignAndScene) {
  const std::uint64_t hash = RunSeed(7).hash;
  EXPECT_NE(hash, RunSeed(8).hash);
  EXPECT_NE(hash, RunSeed(7, true).hash);
  EXPECT_NE(hash, RunSeed(7, false, kTableTop_m + 1e-4).hash);
}

// A change of the last bit of each field changes the hash.
TEST(TickHash, ChangesWithOneBitOfAnyField) {
  const auto hash_of = [](const base::HallScan& scan, const loop::TickOutput& output) {
    daemon::TickHash hash;
    hash.Add(scan, output);
    return hash.value();
  };
  const base::HallScan scan;
  const loop::TickOutput output;
  const std::uint64_t reference = hash_of(scan, output);
  base::HallScan other_scan = scan;
  other_scan.field_sensor_T[5].y = 5e-324;
  EXPECT_NE(hash_of(other_scan, output), reference);
  loop::TickOutput other = output;
  other.tool.position_base_m.z = 5e-324;
  EXPECT_NE(hash_of(scan, other), reference);
  other = output;
  other.wrench.force_N.x = -0.0;
  EXPECT_NE(hash_of(scan, other), reference);
  other = output;
  other.currents.current_A[2] = 5e-324;
  EXPECT_NE(hash_of(scan, other), reference);
}

}  // namespace test_daemon_virtual
}  // namespace omni::test
