// Bad input on a small scale: what `omni-bench stress` counts over millions of ticks must be zero over thousands too.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>

#include "service/sim/fields/vec3.h"
#include "tests/bench/stress/stress.h"
#include "tests/support/rig/scan_faults.h"

namespace omni::bench {
namespace test_bench_stress {

TEST(Stress, TickNeverAllocatesOrExceedsLimitsUnderScanFaults) {
  ::setenv("OMNI_DATA_DIR", OMNI_SOURCE_DIR, 1);  // scenes of the source tree, whether built or not
  std::vector<RoomCondition> as_drawn{{.name = "drawn"}, {.name = "turning"}};
  for (RoomCondition& condition : as_drawn) condition.as_drawn = true;  // which needs no calibration
  as_drawn[1].later = [](base::TruthParameters& truth, sim::Random&) { truth.effects.room.turn_rate_rad_s = 1; };
  const auto rows = StressTicks(30'001, 7, as_drawn);
  ::unsetenv("OMNI_DATA_DIR");
  ASSERT_TRUE(rows.ok()) << rows.error();
  const std::size_t faults = sim::ScanFaults().size();
  ASSERT_EQ(rows->size(), faults + 1 + as_drawn.size());
  const auto& all = (*rows)[faults];
  EXPECT_EQ(all["fault"], "all");
  EXPECT_EQ(all["ticks"], 30'001);
  EXPECT_EQ((*rows)[faults + 1]["ticks"], 15'001);
  EXPECT_EQ(rows->back()["condition"], "turning");
  EXPECT_EQ(rows->back()["ticks"], 15'000);
  EXPECT_EQ(all["not_finite"], 0);
  EXPECT_EQ(all["over_limit"], 0);
  EXPECT_EQ(all["allocations"], 0);
  EXPECT_EQ(rows->front()["fault"], "none");
  EXPECT_GT(rows->front()["tracking"], 0.9 * rows->front()["ticks"].get<double>());
}

// The long run must not repeat one minute.
TEST(Stress, LongRunRoomFieldAndMagnetTemperatureVary) {
  const RoomCourse course = MakeRoomCourse(600, 5);
  ASSERT_EQ(course.size(), 601U);
  double field_T = 0, step_T = 0, hottest_K = 0, coolest_K = 100;
  for (std::size_t i = 1; i < course.size(); ++i) {
    field_T = std::max(field_T, base::Norm(course[i].ambient_base_T));
    step_T = std::max(step_T, base::Norm(course[i].ambient_base_T - course[i - 1].ambient_base_T));
    hottest_K = std::max(hottest_K, course[i].magnet_K);
    if (i > 100) coolest_K = std::min(coolest_K, course[i].magnet_K);
  }
  EXPECT_GT(field_T, 5e-6);
  EXPECT_LT(field_T, 50e-6);
  EXPECT_LT(step_T, 6e-6) << "slowly";
  EXPECT_NEAR(hottest_K, 10, 0.1);
  EXPECT_NEAR(coolest_K, 0, 0.1) << "and cools down again";
}

TEST(Stress, EveryFaultChangesTheScan) {
  sim::Random random(3);
  base::HallScan good;
  good.t_ns = 5'000'000'000;
  good.supply_V = 12;
  for (std::size_t i = 0; i < good.field_sensor_T.size(); ++i) {
    good.field_sensor_T[i] = {1e-4 * static_cast<double>(i + 1), 2e-4, -3e-4};
  }
  for (const sim::ScanFault& fault : sim::ScanFaults().subspan(1)) {
    sim::FaultContext context{random, {}, {}, {}, 0b101, 1e-6};
    context.held.t_ns = 4'000'000'000;
    context.other_magnet.fill({1e-5, 0, 0});
    base::HallScan scan = good;
    fault.apply(context, scan);
    bool differs = scan.t_ns != good.t_ns || scan.sequence != good.sequence || scan.device_faults != 0 ||
                   scan.age_ns != good.age_ns || scan.saturated_mask != 0 || !(scan.supply_V == good.supply_V);
    for (std::size_t i = 0; i < good.field_sensor_T.size(); ++i) {
      differs = differs || !(scan.field_sensor_T[i] == good.field_sensor_T[i]);
    }
    differs = differs || scan.step_current_A != good.step_current_A || scan.tick_lead_ns != good.tick_lead_ns;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) {
      differs = differs || !(scan.coil_current_A[k] == 0) || !(scan.coil_temperature_C[k] == 0);
    }
    EXPECT_TRUE(differs) << fault.name;
  }
}

}  // namespace test_bench_stress
}  // namespace omni::bench
