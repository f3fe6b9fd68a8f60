// The rendered pulse of a detent click.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "service/loop/inputs.h"

namespace omni::loop {
namespace test_loop_detent {

haptics::Output Touching() {
  haptics::Output output;
  output.contact_count = 1;
  output.contacts[0].normal_base = {0, 0.6, 0.8};
  return output;
}

InputTracker WithDetent(bool on) {
  InputTracker tracker;
  if (on) tracker.on = SourceBit(base::InputSource::kDetent);
  return tracker;
}

TEST(Detent, PulsesOnceOnPressAndOnceOnRelease) {
  const base::InputMapping mapping = base::DefaultMapping();
  DetentState state;
  double least_N = 0, most_N = 0, sum_Ns = 0;
  int ticks = 0;
  for (int ms = 0; ms < 300; ++ms) {
    const bool on = ms >= 50 && ms < 200;
    const base::Vec3 f = DetentForce_N(mapping, WithDetent(on), Touching(), 1e-3, state);
    const double along_N = 0.6 * f.y + 0.8 * f.z;
    EXPECT_NEAR(f.x, 0, 1e-12);
    EXPECT_NEAR(0.8 * f.y - 0.6 * f.z, 0, 1e-12) << "along the normal and nowhere else";
    EXPECT_TRUE(along_N == 0 || (ms >= 50 && ms < 62) || (ms >= 200 && ms < 212)) << ms;
    least_N = std::min(least_N, along_N);
    most_N = std::max(most_N, along_N);
    sum_Ns += 1e-3 * along_N;
    ticks += along_N != 0 ? 1 : 0;
  }
  const double pulse_N = mapping.thresholds.detent_pulse_N;
  EXPECT_NEAR(least_N / -pulse_N, 1, 0.02);
  EXPECT_NEAR(most_N / (kDetentReturn * pulse_N), 1, 0.02);
  EXPECT_GE(ticks, 20);
  EXPECT_LT(sum_Ns, 0);
}

TEST(Detent, NoPulseWithoutListenerOrAmplitude) {
  base::InputMapping mapping = base::DefaultMapping();
  mapping.at(base::InputComponent::kSqueeze) = {};
  DetentState state;
  for (int ms = 0; ms < 100; ++ms) {
    EXPECT_EQ(DetentForce_N(mapping, WithDetent(ms % 40 > 20), Touching(), 1e-3, state), base::Vec3{});
  }
  mapping = base::DefaultMapping();
  mapping.thresholds.detent_pulse_N = 0;
  for (int ms = 0; ms < 100; ++ms) {
    const base::Vec3 f = DetentForce_N(mapping, WithDetent(ms % 40 > 20), Touching(), 1e-3, state);
    EXPECT_EQ(std::abs(f.x) + std::abs(f.y) + std::abs(f.z), 0);
  }
}

}  // namespace test_loop_detent
}  // namespace omni::loop
