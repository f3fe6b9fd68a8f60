// The whole twin in virtual time: what its sensors report, determinism, its recording.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <vector>

#include "firmware/wire/messages.h"
#include "service/config/files/twin_file.h"
#include "service/sim/twin/recording.h"
#include "service/sim/twin/twin_core.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/twin_scenario.h"

namespace omni::sim {
namespace test_sim_twin {

using support::HoldingTwin;
using support::NominalDevice;

std::uint64_t Mix(std::uint64_t hash, std::uint64_t word) { return (hash ^ word) * 0x100000001B3ULL; }

// Over the bits of everything in a scan.
std::uint64_t RunHash(const TwinOptions& options, int ticks = 300) {
  const auto twin = MakeVirtualTwin(NominalDevice(), options, 1);
  std::uint64_t hash = 0xCBF29CE484222325ULL;
  base::HallScan scan;
  for (int i = 0; i < ticks; ++i) {
    EXPECT_EQ(twin->Read(scan, 0), device::ReadStatus::kScan);
    hash = Mix(hash, static_cast<std::uint64_t>(scan.t_ns));
    for (std::size_t s = 0; s < base::kSensorCount; ++s) {
      for (const double b : {scan.field_sensor_T[s].x, scan.field_sensor_T[s].y, scan.field_sensor_T[s].z}) {
        hash = Mix(hash, std::bit_cast<std::uint64_t>(b));
      }
      hash = Mix(hash, static_cast<std::uint64_t>(scan.age_ns[s]));
    }
    for (const double current_A : scan.coil_current_A) hash = Mix(hash, std::bit_cast<std::uint64_t>(current_A));
    EXPECT_TRUE(twin->Write({{std::sin(0.1 * i), std::cos(0.1 * i), 1.0}}));
  }
  return hash;
}

TEST(SimTwin, EqualInputsGiveBitIdenticalScans) {
  const TwinOptions options = HoldingTwin({0.01, 0, 0.05});
  const std::uint64_t hash = RunHash(options);
  EXPECT_EQ(hash, RunHash(options));
  TwinOptions other = options;
  other.seed = 2;
  EXPECT_NE(hash, RunHash(other));
  other = options;
  other.flip_coil_sign = true;
  EXPECT_NE(hash, RunHash(other));
  other = options;
  other.truth = config::IdealTwin();
  const std::uint64_t with_effects = RunHash(other);
  EXPECT_NE(hash, with_effects);
  EXPECT_EQ(with_effects, RunHash(other));
  other = options;
  other.imperfect = false;
  EXPECT_NE(hash, RunHash(other));
}

TEST(SimTwin, SensorNoiseMatchesTheConfiguredNoise) {
  TwinOptions options = HoldingTwin({0, 0, 0.06});
  options.imperfect = false;
  options.script.waypoints[0].present = false;  // no magnet, no currents: noise only
  const auto twin = MakeVirtualTwin(NominalDevice(), options, 10);
  std::array<double, 3> sum{}, square{};
  double count = 0;
  base::HallScan scan;
  for (int i = 0; i < 3000; ++i) {
    ASSERT_EQ(twin->Read(scan, 0), device::ReadStatus::kScan);
    for (std::size_t s = 0; s < base::kSensorCount; ++s) {
      if ((scan.fresh_mask >> s & 1U) == 0) continue;
      const Vec3& b = scan.field_sensor_T[s];
      const std::array<double, 3> axes{b.x, b.y, b.z};
      for (std::size_t a = 0; a < 3; ++a) {
        sum[a] += axes[a];
        square[a] += axes[a] * axes[a];
      }
      ++count;
    }
  }
  const std::array<double, 3> noise_T{8e-7, 8e-7, 1e-6};
  for (std::size_t a = 0; a < 3; ++a) {
    EXPECT_NEAR(std::sqrt(square[a] / count) / noise_T[a], 1, 0.02);
    EXPECT_LT(std::abs(sum[a] / count), 4 * noise_T[a] / std::sqrt(count));
  }
}

TEST(SimTwin, TimestampIsOfTheNewestSampleAndAgesAreRelativeToIt) {
  const auto twin = MakeVirtualTwin(NominalDevice(), HoldingTwin({0, 0, 0.06}), 10);
  base::HallScan scan;
  std::int64_t before_ns = 0;
  int stale = 0;
  for (int i = 0; i < 2000; ++i) {
    ASSERT_EQ(twin->Read(scan, 0), device::ReadStatus::kScan);
    EXPECT_EQ(scan.sequence, static_cast<std::uint64_t>(i) + 1);
    if (i < 3) continue;  // every sensor has sampled by now
    ASSERT_GT(scan.t_ns, before_ns);
    before_ns = scan.t_ns;
    std::int64_t youngest_ns = 1'000'000;
    for (std::size_t s = 0; s < base::kSensorCount; ++s) {
      ASSERT_GE(scan.age_ns[s], 0);
      ASSERT_LE(scan.age_ns[s], 1'100'000);
      youngest_ns = std::min(youngest_ns, scan.age_ns[s]);
      stale += (scan.fresh_mask >> s & 1U) == 0;
    }
    ASSERT_EQ(youngest_ns, 0);
  }
  EXPECT_GT(stale, 0) << "slow oscillators miss a tick now and then";
  EXPECT_LT(stale, 100);
}

TEST(SimTwin, SaturatedAxesAreClippedAndMarked) {
  base::DeviceGeometry device = NominalDevice();
  device.sensor_range_T = 5e-5;
  const auto twin = MakeVirtualTwin(device, HoldingTwin({0, 0, 0.04}), 1);
  base::HallScan scan;
  for (int i = 0; i < 5; ++i) ASSERT_EQ(twin->Read(scan, 0), device::ReadStatus::kScan);
  EXPECT_NE(scan.saturated_mask, 0U);
  for (std::size_t s = 0; s < base::kSensorCount; ++s) {
    const Vec3& b = scan.field_sensor_T[s];
    const std::array<double, 3> axes{b.x, b.y, b.z};
    for (std::size_t a = 0; a < 3; ++a) {
      EXPECT_LE(std::abs(axes[a]), 5e-5 * 1.001);
      const bool marked = (scan.saturated_mask >> (3 * s + a) & 1U) != 0;
      EXPECT_EQ(marked, std::abs(axes[a]) > 4.99e-5) << s << " " << a;
    }
  }
}

TEST(SimTwin, PenTakenAwayLeavesNoField) {
  TwinOptions options = HoldingTwin({0, 0, 0.05});
  options.imperfect = false;
  options.script.waypoints.push_back({0.1, {0, 0, 0.05}, {0, 0, -1}, false});
  options.script.waypoints[0].present = true;
  options.script.waypoints.insert(options.script.waypoints.begin() + 1, {0.1, {0, 0, 0.05}, {0, 0, -1}, true});
  const auto twin = MakeVirtualTwin(NominalDevice(), options, 1);
  base::HallScan scan;
  const auto strongest = [&] {
    double worst = 0;
    for (const Vec3& b : scan.field_sensor_T) worst = std::max(worst, Norm(b));
    return worst;
  };
  for (int i = 0; i < 50; ++i) twin->Read(scan, 0);
  EXPECT_GT(strongest(), 1e-4);
  for (int i = 0; i < 100; ++i) twin->Read(scan, 0);
  EXPECT_LT(strongest(), 1e-5);
}

TEST(SimTwin, BadSetPointsAreRefused) {
  const auto twin = MakeVirtualTwin(NominalDevice(), HoldingTwin({0, 0, 0.05}), 1);
  EXPECT_FALSE(twin->Write({{std::nan(""), 0, 0}}));
  EXPECT_FALSE(twin->Write({{0, INFINITY, 0}}));
  EXPECT_FALSE(twin->Write({{0, 0, 15.01}}));
  EXPECT_TRUE(twin->Write({{0, 0, -15}}));
  EXPECT_EQ(twin->counters().send_failed, 3U);
  EXPECT_EQ(twin->counters().sent, 1U);
}

TEST(SimTwin, EndsAfterItsDuration) {
  const auto twin = MakeVirtualTwin(NominalDevice(), HoldingTwin({0, 0, 0.05}), 0.05);
  base::HallScan scan;
  int ticks = 0;
  while (twin->Read(scan, 0) == device::ReadStatus::kScan) ++ticks;
  EXPECT_EQ(ticks, 50);
  EXPECT_EQ(twin->Read(scan, 0), device::ReadStatus::kEnd);
}

TEST(SimTwin, RecordingHoldsEveryTick) {
  const test::TempFolder folder;
  TwinOptions options = HoldingTwin({0.01, 0, 0.05});
  options.recording_path = folder.Path("truth.csv");
  {
    const auto twin = MakeVirtualTwin(NominalDevice(), options, 10);
    base::HallScan scan;
    for (int i = 0; i < 9000; ++i) {  // more than the queue holds
      ASSERT_EQ(twin->Read(scan, 0), device::ReadStatus::kScan);
      twin->Write({{0, 0, 3}});
    }
  }
  const support::Table table = support::ReadTable(options.recording_path);
  ASSERT_EQ(table.rows.size(), 9000U);
  for (std::size_t i = 1; i < table.rows.size(); ++i) {
    ASSERT_EQ(table.rows[i].size(), table.columns.size());
    ASSERT_EQ(table.At(i, "t_ns") - table.At(i - 1, "t_ns"), 1e6);
  }
  EXPECT_EQ(table.At(8999, "present"), 1);
  EXPECT_NEAR(table.At(8999, "current_z_A"), 3, 0.01);
  EXPECT_EQ(table.At(8999, "faults"), 0);
  EXPECT_NEAR(table.At(8999, "tip_z_m"), table.At(8999, "magnet_z_m") - 0.005, 1e-12);
  EXPECT_NEAR(table.At(8999, "command_age_s"), 0.001, 1e-12);
  EXPECT_GT(table.At(8999, "gap_m"), 0);
}

TEST(SimTwin, FullDiskEndsTheRecordingNotTheTwin) {
  testing::internal::CaptureStderr();
  {
    const auto recording = Recording::Open("/dev/full");
    ASSERT_TRUE(recording.ok()) << recording.error();
    for (int i = 0; i < 1000; ++i) recording.value()->Add(TruthRow{});
  }
  const std::string said = testing::internal::GetCapturedStderr();
  EXPECT_NE(said.find("/dev/full: recording is incomplete, 1000 rows lost"), std::string::npos) << said;
  EXPECT_EQ(std::count(said.begin(), said.end(), '\n'), 1) << said;
  const auto impossible = Recording::Open("/nonexistent/folder/truth.csv");
  ASSERT_FALSE(impossible.ok());
  EXPECT_NE(impossible.error().find("/nonexistent/folder/truth.csv"), std::string::npos);
}

TEST(SimRandom, SequenceDependsOnlyOnTheSeed) {
  Random random(1);
  const std::uint64_t first = random.Bits();
  EXPECT_EQ(first, Random(1).Bits());
  EXPECT_NE(first, Random(2).Bits());
  double sum = 0;
  double square = 0;
  for (int i = 0; i < 100000; ++i) {
    const double x = random.Normal();
    sum += x;
    square += x * x;
  }
  EXPECT_NEAR(sum / 100000, 0, 0.015);
  EXPECT_NEAR(square / 100000, 1, 0.02);
}

}  // namespace test_sim_twin
}  // namespace omni::sim
