// Clay that a slow hand pulls out and holds, on the whole twin in a room (a simulation).
#include <gtest/gtest.h>

#include <cmath>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/daemon/virtual_run.h"
#include "service/loop/realtime.h"
#include "service/sim/twin/twin.h"
#include "service/tools/common/files.h"
#include "service/tools/scene/scene.h"
#include "tests/support/process/temp_folder.h"
#include "tests/support/rig/loop_replay.h"

namespace omni::test {
namespace {

constexpr double kHold_s = 5;

// Presses the block, waits for .45 s, draws the pen up by 21.7 mm and holds it there.
sim::HandScript PullingHand(double speed_m_s, double& held_s) {
  constexpr double kPull_m = 0.0217;
  sim::HandScript hand;
  hand.stiffness_N_m = 200;
  hand.damping_Ns_m = 3;
  hand.mass_kg = 0.12;
  hand.tremor_m = 5e-5;
  const auto add = [&](double s, double z_m) { hand.waypoints.push_back({s, {-0.009, 0, z_m}, {0, 0, -1}, true}); };
  add(0, 0.068);
  add(0.8, 0.050);
  add(0.5, 0.039);
  add(0.45, 0.039);
  add(kPull_m / speed_m_s, 0.039 + kPull_m);
  held_s = hand.duration_s();
  add(kHold_s, 0.039 + kPull_m);
  add(0.5, 0.068);
  return hand;
}

TEST(ClayHeld, ByAHandThatPullsSlowlyAndHolds) {
  loop::FlushDenormals();
  const auto room = config::FindTwin("");
  ASSERT_TRUE(room.ok());
  const auto config = CalibratedTick(1);
  ASSERT_TRUE(config.ok()) << config.error();
  for (const double speed_m_s : {0.001, 0.003}) {
    const auto scene = tools::LoadLiveScene(tools::ShippedScene("extrusion"), {});
    ASSERT_TRUE(scene.ok());
    double held_s = 0;
    const sim::HandScript hand = PullingHand(speed_m_s, held_s);
    const TempFolder folder;
    auto twin = sim::MakeVirtualTwin(
        config::DefaultDevice(),
        {.seed = 1, .script = hand, .truth = *room, .recording_path = folder.Path("truth.csv")}, hand.duration_s());
    daemon::RunVirtual(*config, *twin, scene->scene);
    twin.reset();  // completes the recording
    const auto truth = tools::CsvTable::Read(folder.Path("truth.csv"));
    ASSERT_TRUE(truth.ok());
    const auto& t_ns = (*truth)["t_ns"];
    double sum_N = 0, lowest_m = 1;
    int n = 0;
    for (std::size_t i = 0; i < truth->rows(); ++i) {
      const double t_s = 1e-9 * (t_ns[i] - t_ns[0]);
      if (t_s < held_s || t_s > held_s + kHold_s) continue;
      sum_N += (*truth)["coil_force_z_N"][i];
      lowest_m = std::min(lowest_m, (*truth)["tip_z_m"][i]);
      ++n;
    }
    EXPECT_GT(lowest_m, 0.0575) << speed_m_s;  // 15 mm over the press
    EXPECT_NEAR(sum_N / n, -0.5, 0.05) << speed_m_s;
  }
}

}  // namespace
}  // namespace omni::test
