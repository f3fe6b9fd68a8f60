// Memory, drift, ripple and nonlinear sensors: sizes as configured, physical laws of each effect.
#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <numbers>

#include "service/sim/coils/effects.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig.h"

namespace omni::sim {
namespace test_sim_effects {

constexpr double kCore_m = 0.015;
constexpr double kMu0 = 4e-7 * std::numbers::pi;

base::TruthEffects Iron() {
  base::TruthEffects effects;
  effects.core_conductivity_S_m = 1e7;
  return effects;
}

// D / D(0) of a sphere in a uniform field [Wait 1951], straight from the modified spherical Bessel function of order 1:
// i1 = cosh x / x - sinh x / x^2, over e^x / 2x.
std::complex<double> Sphere(double frequency_Hz) {
  const double mu = 1000;
  const std::complex<double> x =
      std::sqrt(std::complex<double>(0, 2 * std::numbers::pi * frequency_Hz * kMu0 * mu * 1e7 * kCore_m * kCore_m));
  const std::complex<double> tail = std::exp(-2.0 * x);
  const std::complex<double> i1 = (1.0 + tail) - (1.0 - tail) / x;
  const std::complex<double> i0 = 1.0 - tail;
  const std::complex<double> g = x * i0 / i1 - 1.0;  // 1 + x i1'/i1, i1' = i0 - 2 i1 / x
  return (2 * mu - g) / (mu + g) / (2 * (mu - 1) / (mu + 2));
}

// Amplitude and phase of a driven core, over the second half of so many periods.
std::complex<double> Response(double frequency_Hz) {
  constexpr int kPeriods = 40, kSteps = 400;  // of a period
  CoreMemory memory(Iron(), kCore_m);
  memory.Start({});
  std::complex<double> sum = 0;
  for (int i = 1; i <= kPeriods * kSteps; ++i) {
    const double phase_rad = 2 * std::numbers::pi * i / kSteps;
    const double induced = std::sin(phase_rad);
    memory.Step({0, induced, 0}, 1 / (kSteps * frequency_Hz));
    if (2 * i > kPeriods * kSteps) {
      sum += (memory.moment_Am2().y + induced) * std::exp(std::complex<double>(0, -phase_rad));
    }
  }
  return sum * std::complex<double>(0, 4) / static_cast<double>(kPeriods * kSteps);
}

TEST(SimEddies, DrivenCoreAnswersLikeASphere) {
  for (const double f : {0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3000.0}) {
    EXPECT_LT(std::abs(Response(f) - Sphere(f)), 1e-3) << f << " Hz";
  }
}

TEST(SimEddies, EddyMomentDecaysAtRest) {
  CoreMemory memory(Iron(), kCore_m);
  memory.Start({});
  memory.Step({0.3, 0, 0}, 1e-3);
  EXPECT_LT(memory.moment_Am2().x, -1e-3);
  memory.Step({0.3, 0, 0}, 1e3);
  EXPECT_NEAR(memory.moment_Am2().x, 0, 1e-6);
}

TEST(SimRemanence, HysteresisLoopHasConfiguredSizeAndIsSymmetric) {
  base::TruthEffects effects;
  effects.remanence_Am2 = 4e-3;
  CoreMemory memory(effects, kCore_m);
  memory.Start({});
  EXPECT_EQ(memory.moment_Am2().x, 0);
  const auto drive = [&](double from, double to) {
    for (int i = 1; i <= 100; ++i) memory.Step({from + (to - from) * i / 100, 0, 0}, 1e-3);
    return memory.moment_Am2().x;
  };
  EXPECT_NEAR(drive(0, 0.1), -4e-3, 1e-12) << "fully dragged: behind by the whole string";
  EXPECT_NEAR(drive(0.1, -0.1), 4e-3, 1e-12);
  EXPECT_NEAR(drive(-0.1, 0.1), -4e-3, 1e-12);
  const double small = drive(0.1, 0.099);  // within the shortest string: the core does not follow
  EXPECT_NEAR(small, -3e-3, 1e-12);
  EXPECT_NEAR(drive(0.099, 0.1), -4e-3, 1e-12);
}

// Rate-independent: however finely the same path is walked.
TEST(SimRemanence, DoesNotDependOnSpeed) {
  base::TruthEffects effects;
  effects.remanence_Am2 = 4e-3;
  CoreMemory slow(effects, kCore_m);
  CoreMemory fast(effects, kCore_m);
  slow.Start({});
  fast.Start({});
  for (int i = 1; i <= 1000; ++i) {
    const double x = 0.01 * i / 1000;
    slow.Step({x, 0, 0}, 1e-3);
    if (i % 10 == 0) fast.Step({x, 0, 0}, 1e-3);
  }
  EXPECT_NEAR(slow.moment_Am2().x, fast.moment_Am2().x, 1e-12);
}

TEST(SimEnvironment, DriftAndWarmingAreRamps) {
  base::TruthEffects effects;
  effects.ambient_drift_T = 5e-7;
  effects.magnet_warming_K = 10;
  effects.earth_field_base_T = {2e-5, 0, -4e-5};
  effects.run_s = 20;
  Random random(5);
  const Environment environment(effects, random);
  EXPECT_EQ(Norm(environment.At(0).background_base_T), 0);
  EXPECT_NEAR(Norm(environment.At(10).background_base_T), 2.5e-7, 1e-15);
  EXPECT_NEAR(Norm(environment.At(1000).background_base_T), 5e-7, 1e-15);
  EXPECT_NEAR(environment.At(20).magnet_scale, 0.988, 1e-12);
  effects.background_known = false;
  const Environment raw(effects, random);
  EXPECT_EQ(raw.At(0).background_base_T, effects.earth_field_base_T);
}

// 12 V, 20 kHz, 2 mH, half the time on: 75 mA.
TEST(SimRipple, MatchesTheDocumentedFigure) {
  EXPECT_NEAR(RipplePeakToPeak(6, 12, 1, 2e-3, 20e3), 0.075, 1e-9);
  EXPECT_EQ(RipplePeakToPeak(0, 12, 1, 2e-3, 20e3), 0);
}

base::DeviceGeometry Device() { return support::NominalDevice(); }
const MagnetPose kPose{{0.01, 0.02, 0.06}, Vec3{0, 0, -1}};

TEST(SimRigEffects, ExactCalibrationContainsTheRawBackground) {
  RigOptions options{.sizes = UncalibratedImperfections(), .noise = NoiseMode::kNone};
  options.effects.earth_field_base_T = {2e-5, 1e-5, -4e-5};
  options.effects.background_known = false;
  Rig rig(Device(), options);
  const base::Calibration exact = rig.ExactCalibration();
  const SensorFields readings = rig.Readings(nullptr, {});
  for (std::size_t i = 0; i < readings.size(); ++i) {
    EXPECT_LT(Norm(readings[i] - exact.sensors[i].background_sensor_T), 1e-15);
    EXPECT_GT(Norm(readings[i]), 4e-5);
  }
}

TEST(SimRigEffects, WarmMagnetIsWeaker) {
  RigOptions options{.sizes = NoImperfections(), .noise = NoiseMode::kNone};
  options.effects.magnet_warming_K = 10;
  options.effects.run_s = 1;
  Rig rig(Device(), options);
  const Vec3 cold = rig.Readings(&kPose, {})[0];
  rig.SetTime(1);
  EXPECT_NEAR(Norm(rig.Readings(&kPose, {})[0]) / Norm(cold), 0.988, 1e-9);
}

// The best line over 12 gauss is the calibrated gain: no deviation is larger than configured.
TEST(SimRigEffects, NonlinearSensorDeviatesWithinItsDataSheetLimit) {
  RigOptions options{.sizes = NoImperfections(), .noise = NoiseMode::kNone};
  options.sizes.sensor_nonlinearity = 4e-4;
  Rig rig(Device(), options);
  const base::Calibration exact = rig.ExactCalibration();
  const double range_T = 12e-4;
  double greatest = 0;
  for (int i = -10; i <= 10; ++i) {
    const SensorFields readings = rig.Readings(nullptr, {1.7 * i, 0, 0});
    for (std::size_t s = 0; s < readings.size(); ++s) {
      const double straight_T = exact.sensors[s].current_map_T_A[0] * 1.7 * i;
      if (!(std::abs(straight_T) <= range_T)) continue;
      const double share = std::abs(rig.imperfections().sensors[s].nonlinearity.x);
      EXPECT_LE(std::abs(readings[s].x - straight_T), share * range_T * 1.0001);
      greatest = std::max(greatest, std::abs(readings[s].x - straight_T) / range_T);
    }
  }
  EXPECT_GT(greatest, 1e-5);
}

TEST(SimRigEffects, RemanenceCarriesOverBetweenScans) {
  RigOptions options{.sizes = NoImperfections(), .noise = NoiseMode::kNone, .saturation = false};
  options.effects.remanence_Am2 = 4e-3;
  Rig rig(Device(), options);
  Random random(1);
  const Vec3 first = rig.Scan(&kPose, {}, random).field_sensor_T[0];
  EXPECT_EQ(first, rig.Readings(&kPose, {})[0]);
  rig.Scan(&kPose, {0, 0, 10}, random);
  const Vec3 up = rig.Scan(&kPose, {}, random).field_sensor_T[0];
  rig.Scan(&kPose, {0, 0, -10}, random);
  const Vec3 down = rig.Scan(&kPose, {}, random).field_sensor_T[0];
  EXPECT_GT(Norm(up - down), 3e-7) << "twice 4 mA m^2 at 96 mm";
  EXPECT_LT(Norm(up - down), 3e-6);
}

}  // namespace test_sim_effects
}  // namespace omni::sim
