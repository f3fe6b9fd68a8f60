// What the core keeps of a motion, found by omni calibrate and followed by the tracker, judged by the digital twin,
// whose core has three strings instead of one.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <memory>

#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/sim/fields/vec3.h"
#include "service/sim/twin/loopback.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "service/tracker/tracker.h"

namespace omni::tools {
namespace test_tools_core_memory {

using base::Vec3;

constexpr double kKept_A = 0.012;  // of the twin's 4 mA m2

// To and fro over the base, .5 m/s at most.
class Swing final : public sim::PenMotion {
 public:
  State StateAt(double t_s) const noexcept override {
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

// How far the pose is ahead of the twin's pen along its path.
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
    const auto pen = swing->StateAt(1e-9 * static_cast<double>(scan.t_ns - sim::Loopback::kClockStart_ns));
    const Vec3 error_m = tool.position_base_m - pen.pose.centre_base_m;
    lead.mean_m += base::Dot(error_m, pen.velocity_base_m_s);
    weight += base::Norm(pen.velocity_base_m_s);
    lead.error_m += base::Norm(error_m);
    ++scans;
  }
  lead.mean_m /= weight;
  lead.error_m /= scans;
  return lead;
}

// Calibrated by omni calibrate on the twin, whose core's loop has three strings instead of one. Without following it
// the pen is seen half a millimetre ahead of where it is.
TEST(ToolsCoreMemory, CoreHysteresisDoesNotAdvanceSwingingPen) {
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

class Held final : public sim::PenMotion {
 public:
  explicit Held(double height_m) : height_m_(height_m) {}
  State StateAt(double) const noexcept override { return {{{0, 0, height_m_}, {0, 0, -1}}, {}}; }

 private:
  double height_m_;
};

struct Shift {
  double amplitude_m = 0;  // of the height, at the current's frequency
  double sigma_m = 0;      // published, the mean
};

// Of a pen that is held still while the upper coil's current is mean_A + change_A sin(2 pi f t).
Shift ShiftBy(const tracker::Config& config, const base::TruthParameters& truth, std::uint64_t seed, double height_m,
              double mean_A, double change_A, double frequency_Hz) {
  sim::PlantOptions options{.seed = seed};
  options.truth = truth;
  options.motion = std::make_shared<Held>(height_m);
  sim::Loopback base(config::DefaultDevice(), options);
  const auto state = std::make_unique<tracker::State>();
  base::HallScan scan;
  base::ToolState tool;
  std::complex<double> sum;
  Shift shift;
  constexpr int kBegin = 2000, kEnd = 5000;
  for (int n = 0; n < kEnd; ++n) {
    base.Tick(scan);
    tracker::Update(config, scan, *state, tool, true);
    const double phase = 2 * 3.14159265358979 * frequency_Hz * 1e-3 * n;
    base.Write({.current_A = {0, 0, std::min(1.0, 1e-3 * n) * mean_A + change_A * std::sin(phase)}});
    if (n < kBegin) continue;
    sum += tool.position_base_m.z * std::polar(1.0, -phase);
    shift.sigma_m += std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]) / (kEnd - kBegin);
  }
  shift.amplitude_m = std::abs(sum) * 2 / (kEnd - kBegin);
  return shift;
}

// A wall's reaction force must not be mistaken for motion, or the force would feed back into itself. The .3 A are 0.027
// N here: at 350 N/m these may pass for .08 mm.
TEST(ToolsCoreMemory, CoilCurrentsAreNotMistakenForMotion) {
  base::TruthParameters truth = config::IdealTwin();
  truth.imperfections = sim::UncalibratedImperfections();
  constexpr std::uint64_t kSeed = 35;
  const auto done = CalibrateTwin(config::DefaultDevice(), kSeed, truth);
  ASSERT_TRUE(done.ok()) << done.error();
  const tracker::Config config = tracker::MakeConfig(done->outcome.calibration);
  for (const double frequency_Hz : {30.0, 95.0, 160.0}) {
    SCOPED_TRACE(frequency_Hz);
    EXPECT_LT(ShiftBy(config, truth, kSeed, 0.055, 1, 0.3, frequency_Hz).amplitude_m, 0.08e-3);
  }
  // Nor increase a pose's uncertainty.
  const double without_m = ShiftBy(config, truth, kSeed, 0.09, 0, 0, 95).sigma_m;
  EXPECT_LT(ShiftBy(config, truth, kSeed, 0.09, 13, 0.3, 95).sigma_m, 1.5 * without_m);
}

TEST(ToolsCoreMemory, CoreWithoutHysteresisIsMeasuredAsSuch) {
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
