// Haptic textures as gratings of the place: docs/theory/haptics.md, (6.1).
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include <gtest/gtest.h>

#include "tests/haptics/scenario.h"
#include "tests/support/touch/ripple.h"

namespace omni::haptics {
namespace {

constexpr double kTop_m = 0.02, kDepth_m = 0.001;

Material Grated(double wavelength_m, double amplitude_m = 1e-4) {
  Material material;
  material.static_friction = material.dynamic_friction = 0;
  material.texture_amplitude_m = amplitude_m;
  material.texture_wavelength_m = wavelength_m;
  return material;
}

class GratedBlock {
 public:
  explicit GratedBlock(const Material& material)
      : pen_(Built(SceneOf(Block(4, {0.06, 0.06, kTop_m}), material))), plain_N_(material.stiffness_N_m * kDepth_m) {
    pen_.config.stiffness_max_N_m = material.stiffness_N_m;
  }

  void LandAt(double x_m, double y_m) {
    pen_.Slide({x_m, y_m, kTop_m + 0.001}, {x_m, y_m, kTop_m - kDepth_m}, 50);
    pen_.Rest(300);
  }
  double RippleAt(const Vec3& tip) { return pen_.MoveTo(tip).force_base_N.z - plain_N_; }
  // Straight, at this speed; the ripple over the way.
  test::StrokeForce Stroke(const Vec3& from, const Vec3& to, double speed_m_s) {
    test::StrokeForce ripple;
    const double length_m = Norm(to - from);
    for (double way_m = 0; way_m <= length_m; way_m += 1e-3 * speed_m_s) {
      ripple.force_N.push_back(RippleAt(from + (way_m / length_m) * (to - from)));
      ripple.place_m.push_back(way_m);
    }
    return ripple;
  }
  Pen& pen() { return pen_; }

 private:
  Pen pen_;
  double plain_N_;
};

Vec3 OnTop(double x_m, double y_m) { return {x_m, y_m, kTop_m - kDepth_m}; }

TEST(Grating, IsFeltAtItsOwnWavelengthInEveryDirection) {
  constexpr double kWavelength_m = 2e-3, kLength_m = 0.04;
  for (int k = 0; k < 16; ++k) {
    GratedBlock block(Grated(kWavelength_m));
    const double angle = std::numbers::pi * (k + 0.3) / 16;
    const Vec3 along{std::cos(angle), std::sin(angle), 0};
    const Vec3 from = OnTop(-0.02 * along.x, -0.02 * along.y);
    block.LandAt(from.x, from.y);
    const test::StrokeForce ripple = block.Stroke(from, from + kLength_m * along, 0.04);
    std::vector<double> judged(ripple.force_N.end() - 800, ripple.force_N.end());
    double high = 0;
    int rises = 0;
    for (std::size_t i = 1; i < judged.size(); ++i) {
      rises += judged[i - 1] < 0 && judged[i] >= 0 ? 1 : 0;
      high = std::max(high, std::abs(judged[i]));
    }
    EXPECT_NEAR(rises, 800e-3 * 0.04 / kWavelength_m, 1) << k;
    EXPECT_NEAR(high, 0.04, 0.003) << k;
  }
}

// The ripple belongs to the place: it is the same on the way back, and on the next day.
TEST(Grating, ThereAndBackFeelTheSame) {
  for (const double wavelength_m : {1e-3, 3e-3}) {
    GratedBlock block(Grated(wavelength_m));
    block.LandAt(-0.02, 0.003);
    const Vec3 from = OnTop(-0.02, 0.003), to = OnTop(0.02, 0.003);
    const double step_m = wavelength_m / test::kPerWave;
    const auto judged = [&](const test::StrokeForce& stroke, bool back) {
      test::StrokeForce by_x = stroke;
      if (back) {
        for (double& way_m : by_x.place_m) way_m = 0.04 - way_m;
      }
      return test::ForceByPlace(by_x, 0.01, step_m, static_cast<std::size_t>(0.02 / step_m));
    };
    const auto there = judged(block.Stroke(from, to, 0.01), false);
    const auto back = judged(block.Stroke(to, from, 0.01), true);
    EXPECT_GT(test::Correlation(there, back), 0.95) << wavelength_m;

    block.pen().Slide(from, {-0.02, 0.003, 0.04}, 200);
    block.pen().Slide({-0.02, 0.003, 0.04}, {-0.018, 0.003, 0.021}, 200);
    block.LandAt(-0.018, 0.003);
    const auto again = judged(block.Stroke(OnTop(-0.018, 0.003), to, 0.01), false);
    const auto shifted =
        std::vector<double>(there.begin() + static_cast<std::ptrdiff_t>(std::lround(0.002 / step_m)), there.end());
    EXPECT_GT(test::Correlation(shifted, {again.begin(), again.begin() + static_cast<std::ptrdiff_t>(shifted.size())}),
              0.95)
        << wavelength_m;
  }
}

// A pen that rests, however its measured tip shakes, feels a plain surface.
TEST(Grating, NothingAtRest) {
  Random random(7);
  GratedBlock grated(Grated(1e-3)), plain(Grated(1e-3, 0));
  grated.LandAt(0, 0);
  plain.LandAt(0, 0);
  Vec3 shake;
  for (int k = 0; k < 3000; ++k) {
    shake = 0.87 * shake + random.InBox(1.2e-4);  // .14 mm rms, alike for 7 ms
    const double t = 1e-3 * k, tremor_m = 5e-5 * std::sin(2 * std::numbers::pi * 9 * t);
    const Vec3 tip = OnTop(shake.x + tremor_m, shake.y);
    const double rippled_N = grated.RippleAt(tip), smooth_N = plain.RippleAt(tip);
    ASSERT_NEAR(rippled_N, smooth_N, 0.002) << k;
  }
}

TEST(Grating, FadesOutBeforeItCouldAlias) {
  for (const double frequency_Hz : {260.0, 400.0, 900.0, 1010.0}) {
    GratedBlock block(Grated(5e-4));
    block.LandAt(-0.05, 0);
    const double speed_m_s = frequency_Hz * 5e-4;
    const test::StrokeForce ripple = block.Stroke(OnTop(-0.05, 0), OnTop(0.05, 0), speed_m_s);
    const std::size_t half = ripple.force_N.size() / 2;
    for (std::size_t i = half; i < ripple.force_N.size(); ++i)
      ASSERT_NEAR(ripple.force_N[i], 0, 1e-9) << frequency_Hz << " " << i;
  }
}

// A stroke that turns goes on without a jump.
TEST(Grating, TurnsWithoutAJump) {
  GratedBlock block(Grated(1e-3));
  block.LandAt(0.02, 0);
  double last_N = 0, most_N = 0;
  for (int k = 0; k < 6000; ++k) {  // 40 mm/s around a circle of 20 mm
    const double angle = 0.04 / 0.02 * 1e-3 * k;
    const double now_N = block.RippleAt(OnTop(0.02 * std::cos(angle), 0.02 * std::sin(angle)));
    if (k > 500) most_N = std::max(most_N, std::abs(now_N - last_N));
    last_N = now_N;
  }
  EXPECT_LT(most_N, 1.5 * 0.04 * 2 * std::numbers::pi * 40e-3);
}

}  // namespace
}  // namespace omni::haptics
