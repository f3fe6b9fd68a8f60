// What the core keeps of a motion, found by omni calibrate and followed by the tracker, judged by the digital twin,
// whose core has three strings instead of one.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "service/config/device_file.h"
#include "service/config/twin_file.h"
#include "service/sim/loopback.h"
#include "service/sim/vec3.h"
#include "service/tools/calibrate_twin.h"
#include "service/tracker/tracker.h"

namespace omni::tools {
namespace test_tools_core_memory {

using base::Vec3;
using sim::operator+;
using sim::operator-;
using sim::operator*;

constexpr double kKept_A = 0.012;  // of the twin's 4 mA m2

// To and fro over the base, .5 m/s at most.
class Swing final : public sim::PenMotion {
 public:
  State At(double t_s) const noexcept override {
    constexpr double kRadius_m = 0.09, kAngle = 0.3, kRate = 0.5 / (kRadius_m * kAngle);
    const double angle = kAngle * std::sin(kRate * t_s), rate = kAngle * kRate * std::cos(kRate * t_s);
    const Vec3 up{0, 0, 1}, side{0.8, 0.6, 0};
    return {{kRadius_m * (std::sin(angle) * side + std::cos(angle) * up), {0, 0, -1}},
            kRadius_m * rate * (std::cos(angle) * side - std::sin(angle) * up)};
  }
};

struct Lead {
  double mean_m = 0, error_m = 0;
};

// By how much the pose is ahead of the twin's pen along its way.
Lead LeadOf(const tracker::Config& config, const base::TruthParameters& truth, std::uint64_t seed) {
  sim::PlantOptions options{.seed = seed};
  options.truth = truth;
  const auto swing = std::make_shared<Swing>();
  options.motion = swing;
  sim::Loopback base(config::DefaultDevice(), options);
  const auto state = std::make_unique<tracker::State>();
  base::HallScan scan;
  base::ToolState tool;
  Lead lead;
  double weight = 0;
  int scans = 0;
  for (int n = 0; n < 6000; ++n) {
    base.Tick(scan);
    tracker::Update(config, scan, *state, tool);
    if (n < 2000) continue;
    const auto pen = swing->At(1e-9 * static_cast<double>(scan.t_ns - sim::Loopback::kClockStart_ns));
    const Vec3 error_m = tool.position_base_m - pen.pose.centre_base_m;
    lead.mean_m += sim::Dot(error_m, pen.velocity_base_m_s);
    weight += sim::Norm(pen.velocity_base_m_s);
    lead.error_m += sim::Norm(error_m);
    ++scans;
  }
  lead.mean_m /= weight;
  lead.error_m /= scans;
  return lead;
}

// Calibrated by omni calibrate on the twin, whose core's loop has three strings instead of one. Without following it
// the pen is seen half a millimetre ahead of where it is.
TEST(ToolsCoreMemory, APenThatSwingsIsNotSeenAheadOfItself) {
  base::TruthParameters truth = config::IdealTwin();
  truth.imperfections = sim::UncalibratedImperfections();
  truth.effects.remanence_Am2 = 4e-3;
  constexpr std::uint64_t kSeed = 33;
  const auto done = CalibrateTwin(config::DefaultDevice(), kSeed, truth);
  ASSERT_TRUE(done.ok()) << done.error();
  base::Calibration calibration = done->outcome.calibration;
  EXPECT_NEAR(calibration.core_kept_A, kKept_A, 0.25 * kKept_A);
  const Lead follows = LeadOf(tracker::MakeConfig(calibration), truth, kSeed);
  calibration.core_kept_A = 0;  // unknown
  const Lead unknown = LeadOf(tracker::MakeConfig(calibration), truth, kSeed);
  EXPECT_GT(unknown.mean_m, 4e-4);
  EXPECT_LT(std::abs(follows.mean_m), 0.4 * unknown.mean_m);
  EXPECT_LT(follows.error_m, 0.8 * unknown.error_m);
}

TEST(ToolsCoreMemory, OneThatKeepsNothingIsFoundToKeepNothing) {
  base::TruthParameters truth = config::IdealTwin();
  truth.imperfections = sim::UncalibratedImperfections();
  truth.effects.remanence_Am2 = 0;
  const auto done = CalibrateTwin(config::DefaultDevice(), 34, truth);
  ASSERT_TRUE(done.ok()) << done.error();
  const base::Calibration& calibration = done->outcome.calibration;
  EXPECT_GT(calibration.core_kept_A, 0);
  EXPECT_LT(calibration.core_kept_A, 0.25 * kKept_A);
}

}  // namespace test_tools_core_memory
}  // namespace omni::tools
