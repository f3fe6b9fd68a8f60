#include "tests/support/touch/virtual_wall.h"

#include <algorithm>
#include <cmath>
#include <deque>
#include <utility>

#include "service/base/limits.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/stability/stability.h"
#include "service/sim/fields/random.h"
#include "service/tracker/filter/filter.h"
#include "tests/support/usual_limit.h"

namespace omni::test {
namespace {

constexpr double kTick_s = base::kTickPeriod_s;
constexpr int kSubSteps = 50;
constexpr double kSubStep_s = kTick_s / kSubSteps;
constexpr double kAway_s = 0.3, kMove_s = 0.5, kRest_s = 0.5;
constexpr double kWaits_m = 2e-3;  // waiting position of the hand

haptics::Config ConfigFor(const WallLoop& loop, WallRule rule) {
  haptics::Config config;
  config.coil_lag_s = loop.coil_lag_s;
  config.stiffness_max_N_m = 1e9;
  config.ramp_s = 0;
  if (rule == WallRule::kFixed) {
    config.hand_damping_Ns_m = 1e9;
    config.predict_max_s = 0;
  }
  return config;
}

// The tracker's filter on a noisy position.
class Tracking {
 public:
  explicit Tracking(double noise_m) : noise_m_(noise_m) {
    const double variance_m2 = std::max(noise_m * noise_m, 1e-14);
    for (const std::size_t i : {0U, 6U, 12U}) measured_.covariance[i] = variance_m2;
    measured_.covariance[18] = measured_.covariance[24] = 1e-6;
    measured_.axis_base = {0, 0, -1};
  }

  double Measure(double z_m, bool pushed, sim::Random& random) {
    measured_.position_base_m = {noise_m_ * random.Normal(), noise_m_ * random.Normal(),
                                 z_m + noise_m_ * random.Normal()};
    if (!started_) {
      tracker::ResetFilter({}, measured_, filter_);
    } else {
      tracker::PredictFilter({}, kTick_s, pushed, filter_);
      tracker::CorrectFilter({}, measured_, kTick_s, filter_);
    }
    started_ = true;
    return measured_.position_base_m.z;
  }

  void Fill(haptics::Input& input) const {
    input.device_point_base_m = filter_.position_base_m;
    input.velocity_base_m_s = filter_.velocity_base_m_s;
    if (noise_m_ > 0) input.noise = tracker::NoiseOfPoint(filter_, 0);
  }

 private:
  double noise_m_;
  tracker::PoseMeasurement measured_;
  tracker::FilterState filter_;
  bool started_ = false;
};

// Rest position of the hand's spring, without tremor.
double Wanted_m(const WallScenario& scenario, double t_s) {
  const auto smooth = [](double x) { return x <= 0 ? 0.0 : (x >= 1 ? 1.0 : x * x * (3 - 2 * x)); };
  double share = smooth((t_s - kAway_s) / kMove_s);
  if (scenario.release) share -= smooth((t_s - kAway_s - kMove_s - scenario.hold_s) / kMove_s);
  const double held_s = t_s - kAway_s - kMove_s;
  const bool presses = held_s > 0 && held_s < scenario.hold_s;
  const double press_m = presses ? scenario.press_m * std::sin(2 * 3.141592653589793 * scenario.press_Hz * held_s) : 0;
  return kWaits_m - (kWaits_m + scenario.depth_m) * share + press_m;
}

// The hand under the coil's force.
class Hand {
 public:
  Hand(const WallHand& hand, double coil_lag_s)
      : hand_(hand), coil_share_(coil_lag_s > 0 ? -std::expm1(-kSubStep_s / coil_lag_s) : 1) {}

  void SubStep(double wanted_m, double commanded_N) {
    force_N_ += coil_share_ * (commanded_N - force_N_);
    const double push_N = force_N_ + hand_.stiffness_N_m * (wanted_m - z_m_) - hand_.damping_Ns_m * v_m_s_;
    v_m_s_ += kSubStep_s * push_N / hand_.mass_kg;
    z_m_ += kSubStep_s * v_m_s_;
    given_J_ += force_N_ * v_m_s_ * kSubStep_s;
  }

  double z_m() const { return z_m_; }
  double force_N() const { return force_N_; }
  double given_J() const { return given_J_; }

 private:
  WallHand hand_;
  double coil_share_;
  double z_m_ = kWaits_m, v_m_s_ = 0, force_N_ = 0, given_J_ = 0;
};

}  // namespace

WallRun PressWall(const WallHand& hand, const WallLoop& loop, const WallScenario& scenario, WallRule rule,
                  double stiffness_N_m, std::uint64_t seed) {
  const haptics::Scene scene =
      stiffness_N_m > 0 ? Wall(0, {.stiffness_N_m = stiffness_N_m, .static_friction = 0, .dynamic_friction = 0})
                        : haptics::Scene();
  const haptics::Config config = ConfigFor(loop, rule);
  haptics::State state;
  haptics::Output output;
  haptics::EnterScene(scene, state);
  haptics::Input input{.tracked = true, .limit = UsualLimit()};
  // A delay of zero means "unknown" to haptics.
  input.delay_s = rule == WallRule::kBounded ? std::max(loop.delay_s, 1e-9) : 1e-9;
  sim::Random random(seed);
  Tracking tracking(loop.noise_m);
  Hand plant(hand, loop.coil_lag_s);
  sim::Random shake(seed + 1);
  const sim::Tremor tremor(std::sqrt(3.0) * scenario.tremor_m, shake, scenario.tremor);  // a third of it along z
  struct Sent {
    double due_s, force_N;
  };
  std::deque<Sent> sent;
  double commanded_N = 0;
  WallRun run;
  const double end_s = kAway_s + kMove_s + scenario.hold_s + (scenario.release ? kMove_s + kRest_s : 0);
  const auto ticks = static_cast<int>(std::lround(end_s / kTick_s));
  for (int tick = 0; tick < ticks; ++tick) {
    run.measured_m.push_back(tracking.Measure(plant.z_m(), output.force_base_N != base::Vec3{}, random));
    input.t_ns += 1'000'000;
    tracking.Fill(input);
    input.acting = {true, {0, 0, plant.force_N()}};
    if (rule == WallRule::kFixed) input.noise = {};
    haptics::Step(config, scene, input, state, output);
    run.least_gain = std::min(run.least_gain, output.energy_gain);
    run.gain.push_back(output.energy_gain);
    sent.push_back({tick * kTick_s + loop.delay_s + loop.late_s, output.force_base_N.z});
    for (int i = 0; i < kSubSteps; ++i) {
      const double t_s = tick * kTick_s + i * kSubStep_s;
      while (!sent.empty() && sent.front().due_s <= t_s + 1e-9) {
        commanded_N = sent.front().force_N;
        sent.pop_front();
      }
      base::Vec3 wanted_m{0, 0, Wanted_m(scenario, t_s)}, rate_m_s;
      if (scenario.tremor_m > 0) tremor.AddTo(t_s, wanted_m, rate_m_s);
      plant.SubStep(wanted_m.z, commanded_N);
    }
    run.force_N.push_back(plant.force_N());
  }
  run.given_J = plant.given_J();
  run.stiffness_N_m =
      rule == WallRule::kBounded ? std::min(stiffness_N_m, output.stiffness_offered_N_m) : stiffness_N_m;
  run.predict_s = rule == WallRule::kBounded ? state.bound.predict_s : 0;
  return run;
}

namespace {

constexpr double kHalf_m = 0.02, kThickness_m = 0.02;

haptics::Scene Slab(const std::vector<base::Vec3>& profile, const haptics::Material& material) {
  haptics::InputObject slab;
  slab.name = "wall";
  // Four vertices per place of the profile: below and above, at both ends of y.
  for (const base::Vec3& top : profile) {
    for (const double y_m : {-kHalf_m, kHalf_m}) {
      slab.vertices_base_m.push_back({top.x, y_m, profile.front().z - kThickness_m});
      slab.vertices_base_m.push_back({top.x, y_m, top.z});
    }
  }
  const auto quad = [&](std::size_t a, std::size_t b, std::size_t c, std::size_t d) {
    const auto index = [](std::size_t i) { return static_cast<std::uint32_t>(i); };
    slab.triangles.push_back({index(a), index(b), index(c)});
    slab.triangles.push_back({index(a), index(c), index(d)});
  };
  const std::size_t last = 4 * (profile.size() - 1);
  for (std::size_t i = 0; i < last; i += 4) {
    quad(i + 1, i + 5, i + 7, i + 3);  // top
    quad(i, i + 2, i + 6, i + 4);      // bottom
    quad(i, i + 4, i + 5, i + 1);      // -y
    quad(i + 2, i + 3, i + 7, i + 6);  // +y
  }
  quad(0, 1, 3, 2);
  quad(last, last + 2, last + 3, last + 1);
  slab.triangle_material.assign(slab.triangles.size(), 0);
  haptics::SceneInput input;
  input.name = "wall";
  input.materials.push_back(material);
  input.objects.push_back(std::move(slab));
  haptics::BuildReport report;
  return haptics::BuildScene(input, report).value();
}

}  // namespace

haptics::Scene Wall(double top_m, const haptics::Material& material) {
  return Slab({{-kHalf_m, 0, top_m}, {kHalf_m, 0, top_m}}, material);
}

haptics::Scene Ridges(double top_m, double pitch_m, double height_m, const haptics::Material& material) {
  std::vector<base::Vec3> profile;
  const int halves = static_cast<int>(std::lround(4 * kHalf_m / pitch_m));
  for (int k = 0; k <= halves; ++k) {
    profile.push_back({-kHalf_m + 0.5 * pitch_m * k, 0, k % 2 == 0 ? top_m : top_m - height_m});
  }
  return Slab(profile, material);
}

// A first-order high pass.
double RmsAbove(const std::vector<double>& x, std::size_t from, std::size_t to, double from_Hz) {
  const double share = -std::expm1(-2 * 3.141592653589793 * from_Hz * base::kTickPeriod_s);
  double slow = x[from];
  std::vector<double> fast;
  for (std::size_t i = from; i < to; ++i) {
    slow += share * (x[i] - slow);
    fast.push_back(x[i] - slow);
  }
  return RmsAboutMean(fast, fast.size() / 2, fast.size());
}

double RmsAboutMean(const std::vector<double>& x, std::size_t from, std::size_t to) {
  double sum = 0, squares = 0;
  for (std::size_t i = from; i < to; ++i) sum += x[i];
  const double mean = sum / static_cast<double>(to - from);
  for (std::size_t i = from; i < to; ++i) squares += (x[i] - mean) * (x[i] - mean);
  return std::sqrt(squares / static_cast<double>(to - from));
}

// About a + b (i - middle), with b = sum (i - middle) x / sum (i - middle)^2.
double RmsAboutLine(const std::vector<double>& x, std::size_t from, std::size_t to) {
  const double middle = 0.5 * static_cast<double>(from + to - 1);
  double slope = 0, squares = 0;
  for (std::size_t i = from; i < to; ++i) {
    const double away = static_cast<double>(i) - middle;
    slope += away * x[i];
    squares += away * away;
  }
  std::vector<double> left(x.begin() + static_cast<std::ptrdiff_t>(from), x.begin() + static_cast<std::ptrdiff_t>(to));
  for (std::size_t i = 0; i < left.size(); ++i) {
    left[i] -= slope / squares * (static_cast<double>(from + i) - middle);
  }
  return RmsAboutMean(left, 0, left.size());
}

}  // namespace omni::test
