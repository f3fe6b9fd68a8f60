// The watch over swings: hands that are lighter, and loops that are later, than the rule of stability assumes.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <random>

#include "service/haptics/scene/scene.h"
#include "service/haptics/stability/contact_watch.h"
#include "tests/haptics/scenario.h"
#include "tests/support/touch/virtual_wall.h"

namespace omni::haptics {
namespace test_haptics_swing {

using test::PressWall;
using test::WallHand;
using test::WallLoop;
using test::WallRule;
using test::WallRun;

constexpr double kAsked_N_m = 6000;  // the rule decides
constexpr std::size_t kSecond = 1000;

// Above 30 Hz, in the last second.
double Buzz_N(const WallRun& run) {
  return test::RmsAbove(run.force_N, run.force_N.size() - 2 * kSecond, run.force_N.size(), 30);
}

// Hands of 10 to 50 g with little damping, and replies up to 3 ms later than the base reports.
TEST(SwingWatch, LimitsBuzzWithLightHandsAndLateReplies) {
  for (const double mass_kg : {0.01, 0.02, 0.05}) {
    for (const double damping_Ns_m : {0.1, 0.5}) {
      for (const double late_s : {0.0, 1e-3, 3e-3}) {
        SCOPED_TRACE(testing::Message() << mass_kg << " kg, " << damping_Ns_m << " Ns/m, late " << late_s);
        const WallHand hand{mass_kg, damping_Ns_m};
        const WallLoop loop{.delay_s = 2e-3, .late_s = late_s, .noise_m = 1e-4};
        EXPECT_LT(Buzz_N(PressWall(hand, loop, {}, WallRule::kBounded, kAsked_N_m, 3)), 0.03);
        const WallRun pressed =
            PressWall(hand, loop, {.hold_s = 1, .release = true}, WallRule::kBounded, kAsked_N_m, 3);
        EXPECT_LT(pressed.given_J, 0.015);
      }
    }
  }
}

// No limit cycle: the measured tip keeps to twice its noise, or what is over that dies away.
void ExpectHoldsStill(const WallHand& hand, const WallLoop& loop) {
  SCOPED_TRACE(testing::Message() << hand.mass_kg << " kg, late " << loop.late_s << ", noise " << loop.noise_m);
  const auto last_m = [](const WallRun& of, std::size_t second) {
    const std::size_t end = of.measured_m.size() - second * kSecond;
    return test::RmsAboutMean(of.measured_m, end - kSecond, end);
  };
  const WallRun free = PressWall(hand, {.noise_m = loop.noise_m}, {}, WallRule::kFixed, 0, 3);
  const WallRun run = PressWall(hand, loop, {}, WallRule::kBounded, kAsked_N_m, 3);
  EXPECT_FALSE(last_m(run, 0) > 2 * last_m(free, 0) && last_m(run, 0) >= 0.8 * last_m(run, 1));
}

TEST(SwingWatch, NoLimitCycleWithFirmHands) {
  for (const double mass_kg : {0.05, 0.1, 0.2}) {
    for (const double late_s : {0.0, 1e-3, 2e-3}) {
      for (const double noise_m : {2e-5, 1e-4}) {
        ExpectHoldsStill({mass_kg, 1}, {.delay_s = 2e-3, .late_s = late_s, .noise_m = noise_m});
      }
    }
  }
}

// The least damped hands, and replies up to 5 ms later than reported.
TEST(SwingWatch, NoLimitCycleWithLightHandsAndLateReplies) {
  for (const double mass_kg : {0.02, 0.05}) {
    for (const double late_s : {2e-3, 3e-3, 5e-3}) {
      for (const double noise_m : {1e-4, 3e-4}) {
        ExpectHoldsStill({mass_kg, 0.1}, {.delay_s = 2e-3, .late_s = late_s, .noise_m = noise_m});
      }
    }
  }
}

// Longer in the air than in contact: 40 mJ and 4.6 mm in a second otherwise.
TEST(SwingWatch, HeavyPenDoesNotKeepBouncing) {
  const WallHand hand{0.2, 1};
  const WallLoop loop{.delay_s = 1e-3, .late_s = 5e-3, .noise_m = 2e-5};
  const WallRun run = PressWall(hand, loop, {.hold_s = 1, .release = true}, WallRule::kBounded, kAsked_N_m, 2004);
  EXPECT_LT(run.given_J, 0.01);
}

// The nine hands of the rule.
TEST(SwingWatch, DoesNotReduceStiffnessForFirmHands) {
  for (const double mass_kg : {0.05, 0.1, 0.2}) {
    for (const double damping_Ns_m : {1.0, 2.0, 5.0}) {
      for (const double noise_m : {2e-5, 1e-4, 3e-4}) {
        SCOPED_TRACE(testing::Message() << mass_kg << " kg, " << damping_Ns_m << " Ns/m, noise " << noise_m);
        const WallRun run = PressWall({mass_kg, damping_Ns_m}, {.delay_s = 2e-3, .noise_m = noise_m}, {.hold_s = 2},
                                      WallRule::kBounded, kAsked_N_m, 3);
        EXPECT_EQ(run.least_gain, 1);
      }
    }
  }
}

class SwingWatchHand : public testing::Test {
 protected:
  SwingWatchHand() {
    Material m;
    m.stiffness_N_m = 350;
    pen_ = std::make_unique<Pen>(Built(SceneOf(Block(4, {0.02, 0.02, 0.02}), m)));
  }
  // Half a millimetre above the surface at 0; returns the gain that remains in the end.
  double Move(double middle_m, double amplitude_m, double rate_Hz, double seconds) {
    for (int k = 0; k < 1000 * seconds; ++k) {
      const double z = 0.0205 + middle_m + amplitude_m * std::sin(2 * 3.14159265358979 * rate_Hz * 1e-3 * k);
      pen_->MoveTo({0, 0, z});
    }
    return pen_->output.energy_gain;
  }
  std::unique_ptr<Pen> pen_;
};

TEST_F(SwingWatchHand, TappingKeepsFullGain) { EXPECT_EQ(Move(0, 4e-3, 6, 3), 1); }
TEST_F(SwingWatchHand, TremorKeepsFullGain) { EXPECT_EQ(Move(-3e-3, 2e-4, 10, 3), 1); }
TEST_F(SwingWatchHand, RubbingKeepsFullGain) { EXPECT_EQ(Move(-4e-3, 3e-3, 2, 3), 1); }

// Two waves: where they cancel, short half swings come between longer ones inwards; a light hand's would be shorter.
TEST_F(SwingWatchHand, BeatingTremorKeepsFullGain) {
  struct Beat {
    double amplitude_m, slow_Hz, fast_Hz, phase_rad;
  };
  constexpr double kTurn = 2 * 3.14159265358979;
  for (const Beat& beat : {Beat{2e-3, 8.5, 12, 1}, Beat{1e-3, 8, 12.2, 2.7}}) {
    Move(5e-3, 0, 1, 0.3);
    for (int k = 0; k < 1000; ++k) {
      const double t_s = 1e-3 * k;
      const double waves = std::sin(kTurn * beat.slow_Hz * t_s) + std::sin(kTurn * beat.fast_Hz * t_s + beat.phase_rad);
      pen_->MoveTo({0, 0, 0.0155 + beat.amplitude_m * waves});
      ASSERT_EQ(pen_->output.energy_gain, 1) << beat.slow_Hz << " Hz, tick " << k;
    }
  }
}

// No hand moves at 25 Hz: the surface makes it swing. Lifted and put down again it is as stiff as before.
TEST_F(SwingWatchHand, SwingReducesGainUntilContactEnds) {
  EXPECT_LT(Move(-3e-3, 2e-4, 25, 1), 0.1);
  EXPECT_LT(Move(-3e-3, 0, 1, 1), 0.1);
  EXPECT_EQ(Move(5e-3, 0, 1, 0.3), 1);
  EXPECT_EQ(Move(-3e-3, 0, 1, 0.5), 1);
}

// The surface is soft while the hand may still swing, and hard again when it rests.
TEST_F(SwingWatchHand, RestWhileTouchingBringsStiffnessBack) {
  EXPECT_LT(Move(-3e-3, 2e-4, 25, 1), 0.05);
  const double soft = pen_->output.energy_gain;
  EXPECT_EQ(Move(-3e-3, 0, 1, 0.45), soft);
  EXPECT_GT(Move(-3e-3, 0, 1, 0.5), 1.5 * soft);
}

// A motion that goes on without the surface is the hand's own, even where a light hand would swing like that.
TEST_F(SwingWatchHand, MotionThatGoesOnWithoutTheSurfaceGetsItBack) {
  EXPECT_LT(Move(-4e-3, 1.5e-3, 15.5, 1), 0.1);
  EXPECT_LT(Move(-4e-3, 1.5e-3, 15.5, 0.5), 0.1);
  EXPECT_EQ(Move(-4e-3, 1.5e-3, 15.5, 2), 1);
  EXPECT_EQ(Move(-4e-3, 1.5e-3, 15.5, 3), 1);
  // And again after a buzz that the surface does make.
  EXPECT_LT(Move(-4e-3, 2e-4, 25, 1), 0.1);
  EXPECT_EQ(Move(-4e-3, 1.5e-3, 15.5, 3), 1);
}

// Damped so little that it swings on for seconds without the surface: 4 J and 10 cm if that passes for its own motion.
TEST(SwingWatch, LightHandThatSwingsOnDoesNotGetStiffnessBack) {
  const WallHand hand{0.05, 0.1};
  const WallLoop loop{.delay_s = 5e-3, .late_s = 5e-3, .noise_m = 3e-4};
  for (const std::uint64_t seed : {2402U, 2403U, 3U, 4U}) {
    SCOPED_TRACE(seed);
    const WallRun run = PressWall(hand, loop, {}, WallRule::kBounded, kAsked_N_m, seed);
    EXPECT_LT(run.given_J, 0.03);
    EXPECT_LT(Buzz_N(run), 0.03);
  }
}

// Ordinary hands, damped as people's are: whatever they do by themselves, they keep the wall.
WallHand FirmHand(double stiffness_N_m) { return {0.12, 0.01 * stiffness_N_m + 1, stiffness_N_m}; }

// Ticks of a run for which the gain was under a half half a second before, and still is.
int LostTicks(const WallRun& run) {
  int lost = 0;
  for (std::size_t i = 500; i < run.gain.size(); ++i) lost += run.gain[i] < 0.5 && run.gain[i - 500] < 0.5;
  return lost;
}

TEST(OrdinaryHand, RhythmicPressKeepsTheWall) {
  for (const double hand_N_m : {100.0, 200.0, 400.0, 500.0}) {
    for (const double rate_Hz : {1, 3, 4, 5, 8}) {
      for (const double press_m : {1e-3, 2e-3}) {
        SCOPED_TRACE(testing::Message() << hand_N_m << " N/m, " << rate_Hz << " Hz, " << press_m << " m");
        const WallRun run =
            PressWall(FirmHand(hand_N_m), {.delay_s = 1e-3, .noise_m = 1e-4},
                      {.hold_s = 3, .press_m = press_m, .press_Hz = rate_Hz}, WallRule::kBounded, kAsked_N_m, 7);
        EXPECT_EQ(run.least_gain, 1);
      }
    }
  }
}

TEST(OrdinaryHand, TremorKeepsTheWall) {
  for (const double hand_N_m : {100.0, 200.0, 400.0}) {
    for (const double tremor_m : {2e-4, 5e-4, 1e-3, 3e-3}) {
      for (const sim::TremorBand band : {sim::TremorBand{4, 6}, sim::TremorBand{8, 12}, sim::TremorBand{4, 12}}) {
        SCOPED_TRACE(testing::Message() << hand_N_m << " N/m, " << tremor_m << " m from " << band.from_Hz << " Hz");
        const WallRun run =
            PressWall(FirmHand(hand_N_m), {.delay_s = 1e-3, .noise_m = 2e-5},
                      {.hold_s = 4, .tremor_m = tremor_m, .tremor = band}, WallRule::kBounded, kAsked_N_m, 7);
        EXPECT_EQ(LostTicks(run), 0);
      }
    }
  }
}

// From .1 kg, at up to 8 Hz, leaving the wall each time.
TEST(OrdinaryHand, TapsKeepTheWall) {
  for (const double mass_kg : {0.1, 0.2}) {
    for (const double rate_Hz : {4, 6, 8}) {
      for (const double press_m : {3e-3, 6e-3}) {
        SCOPED_TRACE(testing::Message() << mass_kg << " kg, " << rate_Hz << " Hz, " << press_m << " m");
        const WallRun run = PressWall({mass_kg, 3, 200}, {.delay_s = 1e-3, .noise_m = 5e-5},
                                      {.depth_m = 1e-3, .hold_s = 4, .press_m = press_m, .press_Hz = rate_Hz},
                                      WallRule::kBounded, kAsked_N_m, 7);
        EXPECT_EQ(run.least_gain, 1);
      }
    }
  }
}

// Responses four times later than reported: the wall keeps what the hand holds, not a tenth of it.
TEST(SwingWatch, CutsToWhatAFirmHandHoldsWithLateReplies) {
  for (const double mass_kg : {0.1, 0.2}) {
    SCOPED_TRACE(mass_kg);
    const WallRun run = PressWall({mass_kg, 1}, {.delay_s = 1e-3, .late_s = 4e-3, .noise_m = 1e-4}, {},
                                  WallRule::kBounded, kAsked_N_m, 3);
    EXPECT_LT(run.gain.back(), 0.8);
    EXPECT_GT(run.gain.back(), 0.05);
  }
}

TEST_F(SwingWatchHand, TrackingNoiseKeepsFullGain) {
  std::mt19937 generator(3);
  std::normal_distribution<double> normal;
  pen_->input.noise = {1e-8, 0, 1e-4};
  for (int k = 0; k < 20000; ++k) {
    pen_->MoveTo({0, 0, 0.018 + 1e-4 * normal(generator)});
    ASSERT_EQ(pen_->output.energy_gain, 1) << k;
  }
}

}  // namespace test_haptics_swing
}  // namespace omni::haptics
