// The shipped scenes lie where the base is strong: each with the hand that is shipped with it, on the whole twin in a
// room (a simulation), calibrated as `omni calibrate` does it.
#include <gtest/gtest.h>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/daemon/virtual_run.h"
#include "service/loop/realtime.h"
#include "service/sim/twin/twin.h"
#include "service/tools/common/files.h"
#include "service/tools/recordings/report.h"
#include "service/tools/scene/scene.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/loop_replay.h"

namespace omni::test {
namespace {

constexpr std::uint64_t kSeed = 1;

class StrongPlaces : public testing::TestWithParam<const char*> {};

TEST_P(StrongPlaces, GapForceAndTrackingOfAScene) {
  loop::FlushDenormals();
  const auto room = config::FindTwin("");
  const auto config = CalibratedTick(kSeed);
  const std::string path = tools::ShippedScene(GetParam());
  const auto scene = tools::LoadLiveScene(path, {});
  const auto hand = sim::LoadHandScript(tools::FindHandScript(path));
  ASSERT_TRUE(room.ok() && config.ok() && scene.ok() && hand.ok());
  const TempFolder folder;
  auto twin = sim::MakeVirtualTwin(
      config::DefaultDevice(),
      {.seed = kSeed, .script = *hand, .truth = *room, .recording_path = folder.Path("truth.csv")}, hand->duration_s());
  std::vector<tools::TrackedPosition> tracked;
  haptics::VehicleReport car;
  daemon::RunVirtual(*config, *twin, scene->scene, {}, [&](const base::HallScan& scan, const loop::TickOutput& out) {
    car = out.haptics.vehicle;
    if (out.tool.status != base::TrackingStatus::kTracking) return;
    tracked.push_back({static_cast<double>(scan.t_ns), out.tool.position_base_m});
  });
  twin.reset();  // completes the recording
  const auto truth = tools::CsvTable::Read(folder.Path("truth.csv"));
  ASSERT_TRUE(truth.ok()) << truth.error();
  const tools::ForceUse use = tools::MeasureUse(*truth);
  EXPECT_GE(use.reached_N, 1.0);
  EXPECT_LE(use.gap_mean_mm, 12.0);
  EXPECT_LE(tools::CompareTracking(tracked, *truth).mean_mm, 0.35);
  EXPECT_TRUE(!car.on || car.laps >= 1U);
}

INSTANTIATE_TEST_SUITE_P(Scenes, StrongPlaces, testing::Values("extrusion", "dragon", "racetrack"),
                         [](const auto& scene) { return std::string(scene.param); });

}  // namespace
}  // namespace omni::test
