// The forces that docs/scenes.md and README.md promise are those of the model, tip and all.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <string>

#include "service/actuation/actuation.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/loop/tick_config.h"
#include "service/magnetics/nominal.h"

namespace omni::daemon {
namespace test_daemon_force_figures {

struct Most {
  double best_N = 0, worst_N = 0;
};

// Of a cold, calibrated base and a pen that points down at it, its tip this far above the hull.
Most ForceAbove(double height_m) {
  const base::DeviceGeometry& device = config::DefaultDevice();
  const auto calibration =
      config::LoadCalibrationFile(OMNI_SOURCE_DIR "/manifests/device/twin_calibration.toml",
                                  {.device = device, .drawing = magnetics::NominalCalibration(device), .serial = {}});
  EXPECT_TRUE(calibration.ok()) << calibration.error();
  const loop::TickConfig config = loop::MakeTickConfig(device, calibration->calibration);
  base::ToolState tool;
  tool.status = base::TrackingStatus::kTracking;
  tool.ever_tracked = true;
  tool.axis_base = {0, 0, -1};
  tool.device_point_base_m = {0, 0, device.hull_radius_m + height_m};
  tool.position_base_m = {0, 0, tool.device_point_base_m.z + device.magnet.tip_offset_m};
  tool.gap_m = tool.position_base_m.z - device.magnet.half_height_m - device.hull_radius_m;
  std::array<double, base::kCoilCount> air_C{};
  air_C.fill(device.heat.air_C);
  const base::ForceLimit limit = actuation::ComputeForceLimit(config.actuation, tool, air_C);
  EXPECT_TRUE(limit.valid);
  Most most{0, 1e9};
  for (int i = 0; i < 2000; ++i) {  // evenly over the sphere
    const double z = 1 - (2 * i + 1) / 2000.0, turn = 2.399963 * i, r = std::sqrt(1 - z * z);
    const double force_N =
        std::min(base::ForceMax_N(limit, {r * std::cos(turn), r * std::sin(turn), z}), limit.force_max_N);
    most.best_N = std::max(most.best_N, force_N);
    most.worst_N = std::min(most.worst_N, force_N);
  }
  return most;
}

TEST(ForceFigures, DocumentsAgreeWithTheModel) {
  std::ifstream in(OMNI_SOURCE_DIR "/docs/scenes.md");
  const std::string text(std::istreambuf_iterator<char>(in), {});
  const Most near = ForceAbove(0.010), far = ForceAbove(0.030);
  char sentence[200];
  std::snprintf(sentence, sizeof(sentence),
                "%.1f N at 10 mm above the hull in the best direction, %.1f N in the worst; %.1f and %.1f N at 30 mm",
                near.best_N, near.worst_N, far.best_N, far.worst_N);
  EXPECT_NE(text.find(sentence), std::string::npos) << "docs/scenes.md has to say: " << sentence;
}

}  // namespace test_daemon_force_figures
}  // namespace omni::daemon
