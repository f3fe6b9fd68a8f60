// A pen held by a spring of the race track all the time: coils always driven, currents that follow the tracker's own
// noise. The tracker must be about as good there as with coils at rest, and lose no scans.
#include <gtest/gtest.h>

#include <vector>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/daemon/virtual_run.h"
#include "service/loop/tick_config.h"
#include "service/sim/twin/twin.h"
#include "service/tools/recordings/report.h"
#include "service/tools/scene/scene.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/rig.h"

namespace omni::tools {
namespace test_tools_moving {

struct Outcome {
  TrackingErrors errors;
  std::uint64_t held = 0;  // ticks without a fit after the first one
  std::uint32_t laps = 0;
};

// The twin with every effect, the loop with exactly its base's parameters: what is left is the tracker's own.
Outcome RunRacetrack(std::uint64_t seed, double seconds) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const base::TruthParameters& truth = config::IdealTwin();
  const sim::Rig rig(device, sim::OptionsOf(seed, sim::NoiseMode::kLowPower, truth));
  const std::string path = OMNI_SOURCE_DIR "/scenes/racetrack.glb";
  const auto loaded = LoadScene(path, {});
  const auto hand = sim::LoadHandScript(FindHandScript(path));
  EXPECT_TRUE(loaded.ok() && hand.ok());
  if (!loaded.ok() || !hand.ok()) return {};
  const test::TempFolder folder;
  const std::string recording = folder.Path("truth.csv");
  auto twin = sim::MakeVirtualTwin(device, {.seed = seed, .script = *hand, .truth = truth, .recording_path = recording},
                                   seconds);
  std::vector<TrackedPosition> tracked;
  Outcome outcome;
  daemon::RunVirtual(loop::MakeTickConfig(device, rig.ExactCalibration()), *twin, loaded->scene, {},
                     [&](const base::HallScan& scan, const loop::TickOutput& output) {
                       outcome.laps = output.haptics.vehicle.laps;
                       if (output.tool.status == base::TrackingStatus::kTracking) {
                         tracked.push_back({static_cast<double>(scan.t_ns), output.tool.position_base_m});
                       } else if (output.tool.ever_tracked) {
                         ++outcome.held;
                       }
                     });
  twin.reset();
  const auto table = CsvTable::Read(recording);
  EXPECT_TRUE(table.ok());
  if (table.ok()) outcome.errors = CompareTracking(tracked, *table);
  return outcome;
}

TEST(MovingPen, ConstantSpringForceBarelyDegradesTracking) {
  double mean_mm = 0, p95_mm = 0;
  std::uint64_t held = 0, compared = 0;
  constexpr std::uint64_t kSeeds = 3;
  for (std::uint64_t seed = 41; seed < 41 + kSeeds; ++seed) {
    const Outcome outcome = RunRacetrack(seed, 16);
    mean_mm += outcome.errors.mean_mm / kSeeds;
    p95_mm += outcome.errors.p95_mm / kSeeds;
    held += outcome.held;
    compared += outcome.errors.compared_ticks;
    EXPECT_EQ(outcome.laps, 1U) << "seed " << seed
                                << ": the hand drives a lap, whatever the noise does to its steering";
  }
  EXPECT_GT(compared, 47000U);
  EXPECT_LT(mean_mm, 0.8);
  EXPECT_LT(p95_mm, 1.6);
  EXPECT_LT(held, compared / 200);
}

}  // namespace test_tools_moving
}  // namespace omni::tools
