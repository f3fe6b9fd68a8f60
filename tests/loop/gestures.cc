// Gestures of a hand at a surface: seeded random trajectories with tremor and noise of the tracker's size. Every test
// prints the figures that the documentation quotes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <functional>
#include <numbers>
#include <random>

#include "service/loop/inputs.h"

namespace omni::loop {
namespace test_loop_gestures_property {

using base::InputSource;
using base::Vec3;

constexpr double kNoise_m = 30e-6;  // per axis and tick, white: more than the tracker's own within 6 cm
constexpr double kTremor_m = 2e-4;  // rms of the whole displacement, 8 to 12 Hz
constexpr double kPi = std::numbers::pi;

// A hand over a wall z = 0 with a stiffness; what the tip does is added to tremor and noise.
class Hand {
 public:
  explicit Hand(std::uint64_t seed) : random_(seed) {
    for (Wave& wave : waves_) wave = {2 * kPi * Uniform(8, 12), Uniform(0, 2 * kPi)};
    stiffness_N_m_ = Uniform(300, 1000);
  }

  double Uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }

  // One tick with the tip at `wanted`.
  void Tick(const Vec3& wanted) {
    t_ns_ += 1'000'000;
    const Vec3 tip = Seen(wanted);
    haptics::Output output;
    const double depth_m = std::max(0.0, -tip.z);
    if (depth_m > 0) {
      output.contact_count = 1;
      output.contacts[0].normal_base = {0, 0, 1};
      output.contacts[0].gap_m = -depth_m;
      output.tip_normal_force_N = stiffness_N_m_ * depth_m;
    }
    const base::SourceMask before = tracker_.on;
    UpdateInputs({}, mapping_,
                 {.t_ns = t_ns_, .live = true, .tracked = true, .tip_base_m = tip, .axis_base = {0, 0, -1}}, output,
                 nullptr, tracker_);
    for (base::SourceMask rose = tracker_.on & ~before; rose != 0; rose &= rose - 1) {
      ++times_[static_cast<std::size_t>(__builtin_ctzll(rose))];
    }
  }

  // Moves for some seconds along a path of time.
  void Move(double seconds, const std::function<Vec3(double)>& path) {
    const int ticks = static_cast<int>(std::lround(seconds * 1000));
    for (int i = 0; i < ticks; ++i) Tick(path(1e-3 * i));
  }
  void Hold(double seconds, const Vec3& at) {
    Move(seconds, [&](double) { return at; });
  }

  // Down with `speed`, bounced by the wall within `contact_s`, up again.
  void Tap(double x_m, double speed_m_s, double contact_s) {
    const double height_m = 0.006;
    const double way_s = height_m / speed_m_s;
    const double depth_m = speed_m_s * contact_s / kPi;
    Move(way_s, [&](double t) { return Vec3{x_m, 0, height_m - speed_m_s * t}; });
    Move(contact_s, [&](double t) { return Vec3{x_m, 0, -depth_m * std::sin(kPi * t / contact_s)}; });
    Move(way_s, [&](double t) { return Vec3{x_m, 0, speed_m_s * t}; });
  }
  // A contact time for which the tip dips 0.6 to 4 mm.
  double ContactFor(double speed_m_s) {
    return Uniform(std::max(0.015, 0.6e-3 * kPi / speed_m_s), std::min(0.12, 4e-3 * kPi / speed_m_s));
  }

  int Times(InputSource source) const { return times_[static_cast<std::size_t>(source)]; }
  // Of a component of the default mapping.
  std::uint32_t Presses(base::InputComponent component) const {
    return tracker_.inputs.components[static_cast<std::size_t>(component)].press_count;
  }
  double stiffness_N_m() const { return stiffness_N_m_; }

 private:
  struct Wave {
    double rate_rad_s, phase_rad;
  };

  Vec3 Seen(const Vec3& wanted) {
    const double t_s = 1e-9 * static_cast<double>(t_ns_);
    std::array<double, 3> p{wanted.x, wanted.y, wanted.z};
    for (std::size_t i = 0; i < waves_.size(); ++i) {
      p[i % 3] += kTremor_m * std::sqrt(2.0 / 9) * std::sin(waves_[i].rate_rad_s * t_s + waves_[i].phase_rad);
    }
    for (double& value : p) value += kNoise_m * normal_(random_);
    return {p[0], p[1], p[2]};
  }

  std::mt19937_64 random_;
  std::normal_distribution<double> normal_;
  std::array<Wave, 9> waves_{};
  double stiffness_N_m_ = 400;
  std::int64_t t_ns_ = 1'000'000'000;
  const base::InputMapping mapping_ = base::DefaultMapping();
  InputTracker tracker_;
  std::array<int, base::kSourceCount> times_{};
};

TEST(Gestures, EachTapIsDetectedOnce) {
  int taps = 0, found = 0, doubled = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Hand hand(seed);
    hand.Hold(0.3, {0, 0, 0.006});
    const int count = 10;
    for (int i = 0; i < count; ++i) {
      const double speed_m_s = hand.Uniform(0.06, 0.4);
      hand.Tap(hand.Uniform(-0.02, 0.02), speed_m_s, hand.ContactFor(speed_m_s));
      hand.Hold(hand.Uniform(0.6, 0.9), {0, 0, 0.006});  // too long for a double tap
    }
    taps += count;
    found += hand.Times(InputSource::kTap);
    doubled += hand.Times(InputSource::kDoubleTap);
    EXPECT_EQ(hand.Times(InputSource::kTap), count) << "seed " << seed;
  }
  std::printf("taps at 60 to 400 mm/s, 0.6 to 4 mm deep, 300 to 1000 N/m: %d of %d found\n", found, taps);
  EXPECT_EQ(doubled, 0);
}

TEST(Gestures, EachDoubleTapIsDetectedOnce) {
  int pairs = 0, found = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Hand hand(1000 + seed);
    hand.Hold(0.3, {0, 0, 0.006});
    for (int i = 0; i < 5; ++i, ++pairs) {
      const double x_m = hand.Uniform(-0.02, 0.02);
      for (int tap = 0; tap < 2; ++tap) {
        const double speed_m_s = hand.Uniform(0.1, 0.4);
        hand.Tap(x_m + hand.Uniform(-0.002, 0.002), speed_m_s, hand.ContactFor(speed_m_s));
        hand.Hold(hand.Uniform(0.02, 0.12), {x_m, 0, 0.006});
      }
      hand.Hold(0.7, {0, 0, 0.006});
    }
    found += hand.Times(InputSource::kDoubleTap);
    EXPECT_EQ(hand.Times(InputSource::kDoubleTap), 5) << "seed " << seed;
    EXPECT_EQ(hand.Times(InputSource::kTap), 10) << "seed " << seed;
  }
  std::printf("double taps at 100 to 400 mm/s: %d of %d found\n", found, pairs);
}

TEST(Gestures, HoveringIsNoTap) {
  double seconds = 0;
  int taps = 0, touches = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Hand hand(2000 + seed);
    const double gap_m = hand.Uniform(-0.3e-3, 0.6e-3), drift_m = hand.Uniform(0, 0.5e-3);
    hand.Move(10, [&](double t) { return Vec3{0.001 * std::sin(t), 0, gap_m + drift_m * std::sin(0.7 * t)}; });
    seconds += 10;
    taps += hand.Times(InputSource::kTap);
    touches += hand.Times(InputSource::kPress);
  }
  std::printf("hovering -0.3 to 0.6 mm over a surface: %d taps in %.0f s (%d presses)\n", taps, seconds, touches);
  EXPECT_EQ(taps, 0);
  EXPECT_GT(touches, 100) << "else this test tests nothing";
}

TEST(Gestures, TracingIsNoTap) {
  int strokes = 0, taps = 0, flicks = 0;
  double metres = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Hand hand(3000 + seed);
    for (int i = 0; i < 8; ++i, ++strokes) {
      const double speed_m_s = hand.Uniform(0.01, 0.2), down_m_s = hand.Uniform(0.02, 0.15);
      const double depth_m = hand.Uniform(0.5e-3, 2.5e-3), wave_Hz = hand.Uniform(0.5, 3);
      const double length_m = std::max(0.006, 0.3 * speed_m_s);
      const double way_s = (0.006 + depth_m) / down_m_s;
      hand.Move(way_s, [&](double t) { return Vec3{0, 0, 0.006 - down_m_s * t}; });
      hand.Move(length_m / speed_m_s, [&](double t) {
        return Vec3{speed_m_s * t, 0, -depth_m * (1 + 0.4 * std::sin(2 * kPi * wave_Hz * t))};
      });
      hand.Move(way_s, [&](double t) { return Vec3{length_m, 0, -depth_m + down_m_s * t}; });
      hand.Hold(0.15, {length_m, 0, 0.006});
      metres += length_m;
    }
    taps += hand.Times(InputSource::kTap);
    flicks += hand.Times(InputSource::kFlick) + hand.Times(InputSource::kFlickAxial);
  }
  std::printf("tracing %d strokes, %.1f m at 10 to 200 mm/s: %d taps, %d flicks\n", strokes, metres, taps, flicks);
  EXPECT_EQ(taps, 0);
  EXPECT_EQ(flicks, 0);
}

double MinimumJerk(double s) { return s * s * s * (10 - 15 * s + 6 * s * s); }

TEST(Gestures, DetectsFlicksButNotReaching) {
  int flicks = 0, found = 0, axial = 0, axial_found = 0, reaches = 0, false_ones = 0;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    Hand hand(4000 + seed);
    hand.Hold(0.3, {0, 0, 0.05});
    for (int i = 0; i < 4; ++i) {  // there and back: a half sine of displacement
      const double peak_m_s = hand.Uniform(0.7, 2.0), lasts_s = hand.Uniform(0.08, 0.18);
      const double way_m = peak_m_s * lasts_s / kPi, angle = hand.Uniform(0, 2 * kPi);
      const bool along = i % 2 == 1;
      const Vec3 way = along ? Vec3{0, 0, way_m} : Vec3{way_m * std::cos(angle), way_m * std::sin(angle), 0};
      hand.Move(lasts_s, [&](double t) {
        const double s = std::sin(kPi * t / lasts_s);
        return Vec3{way.x * s, way.y * s, 0.05 + way.z * s};
      });
      hand.Hold(0.5, {0, 0, 0.05});
      ++(along ? axial : flicks);
    }
    found += hand.Times(InputSource::kFlick);
    axial_found += hand.Times(InputSource::kFlickAxial);
    EXPECT_EQ(hand.Times(InputSource::kFlick), 2) << "seed " << seed;
    EXPECT_EQ(hand.Times(InputSource::kFlickAxial), 2) << "seed " << seed;

    Hand reaching(5000 + seed);
    Vec3 from{0, 0, 0.05};
    for (int i = 0; i < 8; ++i, ++reaches) {
      const Vec3 to{reaching.Uniform(-0.08, 0.08), reaching.Uniform(-0.08, 0.08), reaching.Uniform(0.03, 0.1)};
      const double lasts_s = reaching.Uniform(0.2, 0.8);
      reaching.Move(lasts_s, [&](double t) {
        const double s = MinimumJerk(t / lasts_s);
        return Vec3{from.x + s * (to.x - from.x), from.y + s * (to.y - from.y), from.z + s * (to.z - from.z)};
      });
      from = to;
      reaching.Hold(reaching.Uniform(0.1, 0.4), from);
    }
    false_ones += reaching.Times(InputSource::kFlick) + reaching.Times(InputSource::kFlickAxial);
  }
  std::printf("flicks peaking at 0.7 to 2 m/s: %d of %d across, %d of %d along the axis; %d in %d reaches\n", found,
              flicks, axial_found, axial, false_ones, reaches);
  EXPECT_EQ(false_ones, 0);
}

TEST(Gestures, DwellStartsWhenStillAndEndsWithMoving) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Hand hand(6000 + seed);
    hand.Hold(0.2, {0, 0, 0.02});
    EXPECT_EQ(hand.Times(InputSource::kHoverDwell), 0);
    hand.Hold(1.0, {0, 0, 0.02});
    EXPECT_EQ(hand.Times(InputSource::kHoverDwell), 1) << seed;
    hand.Move(0.3, [](double t) { return Vec3{0.05 * t, 0, 0.02 - 0.07 * t}; });
    hand.Hold(1.2, {0.015, 0, -0.001});
    EXPECT_EQ(hand.Times(InputSource::kDwell), 1) << seed;
    hand.Move(1.5, [](double t) { return Vec3{0.015 + 0.01 * t, 0, -0.001}; });
    EXPECT_EQ(hand.Times(InputSource::kDwell), 1) << "a tip that slides does not dwell; seed " << seed;
    EXPECT_EQ(hand.Times(InputSource::kHoverDwell), 1) << seed;
  }
}

// Who touches and stays means nothing by it.
TEST(Gestures, HeldTouchPressesOnlySelect) {
  using base::InputComponent;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Hand hand(8000 + seed);
    const double depth_m = 0.4 / hand.stiffness_N_m(), way_m = 0.006 + depth_m;
    hand.Hold(0.3, {0, 0, 0.006});
    hand.Move(0.3, [&](double t) { return Vec3{0, 0, 0.006 - t * way_m / 0.3}; });
    hand.Hold(3, {0, 0, -depth_m});
    hand.Move(0.3, [&](double t) { return Vec3{0, 0, -depth_m + t * way_m / 0.3}; });
    EXPECT_EQ(hand.Presses(InputComponent::kSelect), 1U) << seed;
    for (const auto component : {InputComponent::kThumbstickClick, InputComponent::kSecondary, InputComponent::kMenu,
                                 InputComponent::kSqueeze}) {
      EXPECT_EQ(hand.Presses(component), 0U) << seed << ", component " << static_cast<int>(component);
    }
  }
}

TEST(Gestures, DetentHasForceThresholdAndHysteresis) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    Hand hand(7000 + seed);
    const double deep_m = 1.2 / hand.stiffness_N_m(), at_threshold_m = 0.82 / hand.stiffness_N_m();
    for (int i = 0; i < 5; ++i) {
      hand.Move(0.4, [&](double t) { return Vec3{0, 0, 0.004 - (0.004 + deep_m) * t / 0.4}; });
      hand.Hold(0.5, {0, 0, -at_threshold_m});
      hand.Move(0.4, [&](double t) { return Vec3{0, 0, -at_threshold_m + (0.004 + at_threshold_m) * t / 0.4}; });
    }
    EXPECT_EQ(hand.Times(InputSource::kDetent), 5) << "noise and tremor make no further clicks; seed " << seed;
  }
}

// The pen is put down, picked up, and taken away.
TEST(Gestures, AwayWhenStillUntrackedOrFar) {
  InputTracker tracker;
  const base::InputMapping mapping = base::DefaultMapping();
  std::mt19937_64 random(11);
  std::normal_distribution<double> noise(0, kNoise_m);
  std::int64_t t_ns = 5'000'000'000;
  const auto run = [&](double seconds, bool tracked, Vec3 tip, double wobble_m) {
    for (int i = 0; i < static_cast<int>(seconds * 1000); ++i) {
      t_ns += 1'000'000;
      Vec3 seen = tip;
      seen.x += wobble_m * std::sin(0.01 * i) + noise(random);
      seen.y += noise(random);
      UpdateInputs({}, mapping, {.t_ns = t_ns, .live = tracked, .tracked = tracked, .tip_base_m = seen}, {}, nullptr,
                   tracker);
    }
    return tracker.inputs.components[static_cast<std::size_t>(base::InputComponent::kDocked)].value > 0.5F;
  };
  EXPECT_FALSE(run(60, true, {0, 0, 0.05}, 0.004)) << "a hand moves";
  EXPECT_FALSE(run(15, true, {0.02, 0, 0.05}, 0));
  EXPECT_TRUE(run(10, true, {0.02, 0, 0.05}, 0)) << "lies still";
  EXPECT_FALSE(run(0.1, true, {0.03, 0, 0.05}, 0.004)) << "picked up";
  EXPECT_FALSE(run(1.5, false, {0.03, 0, 0.05}, 0));
  EXPECT_TRUE(run(1, false, {0.03, 0, 0.05}, 0)) << "not seen";
  EXPECT_FALSE(run(0.1, true, {0.03, 0, 0.05}, 0.004)) << "back";
  EXPECT_TRUE(run(3, true, {0.2, 0, 0.05}, 0.004)) << "far";
}

// No sequence of stamps, places and forces makes a click longer than it may be, or a value out of range.
TEST(Gestures, InvalidInputsKeepComponentsInRange) {
  std::mt19937_64 random(12);
  const auto odd = [&]() {
    const double choices[] = {0, 1, -1, 1e300, -1e300, std::nan(""), INFINITY, 0.05, 1e-9};
    return choices[random() % std::size(choices)];
  };
  InputTracker tracker;
  std::int64_t t_ns = 0;
  for (int i = 0; i < 200'000; ++i) {
    const std::int64_t steps[] = {1'000'000, 0, -5, 1'000'000'000'000, INT64_MAX, INT64_MIN, 999'999};
    t_ns = random() % 50 == 0 ? steps[random() % std::size(steps)] : t_ns + 1'000'000 * (t_ns < INT64_MAX - 2'000'000);
    haptics::Output output;
    output.contact_count = static_cast<int>(random() % 3);
    output.contacts[0].normal_base = {odd(), odd(), odd()};
    output.tip_normal_force_N = odd();
    output.joystick = random() % 2 == 0;
    output.thumbstick_x = odd();
    UpdateInputs({}, base::DefaultMapping(),
                 {.t_ns = t_ns, .live = random() % 20 != 0, .tracked = true, .tip_base_m = {odd(), odd(), odd()}},
                 output, nullptr, tracker);
    for (const base::InputValue& value : tracker.inputs.components) {
      ASSERT_TRUE(value.value >= -1 && value.value <= 1) << i;
      ASSERT_LE(value.release_count, value.press_count) << i;
    }
  }
}

}  // namespace test_loop_gestures_property
}  // namespace omni::loop
