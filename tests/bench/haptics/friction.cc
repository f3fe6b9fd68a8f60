// omni-bench friction: the cone, stick-slip and drift of the renderer's friction against Coulomb's law.
#include <algorithm>
#include <cmath>
#include <random>

#include "service/base/limits.h"
#include "service/haptics/contact/frame.h"
#include "service/haptics/haptics.h"
#include "service/haptics/scene/scene.h"
#include "service/haptics/state.h"
#include "tests/bench/harness/bench.h"

namespace omni::bench {
namespace {

using base::Vec3;

constexpr double kPlateHalf_m = 0.05;
constexpr double kBall_m = 0.03;

struct FrictionPair {
  double at_rest, sliding;
};

// A plate with its top at z = 0, cut into n x n squares, or a ball under it whose top is at z = 0.
haptics::InputObject PlateOf(int squares) {
  haptics::InputObject plate;
  for (int i = 0; i <= squares; ++i) {
    for (int j = 0; j <= squares; ++j) {
      plate.vertices_base_m.push_back(
          {kPlateHalf_m * (2.0 * i / squares - 1), kPlateHalf_m * (2.0 * j / squares - 1), 0});
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * (squares + 1) + j); };
  for (int i = 0; i < squares; ++i) {
    for (int j = 0; j < squares; ++j) {
      plate.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      plate.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  plate.triangle_material.assign(plate.triangles.size(), 0);
  plate.name = "plate of " + std::to_string(plate.triangles.size());
  return plate;
}

haptics::InputObject BallOf(int rings) {
  haptics::InputObject ball;
  const int columns = 2 * rings;
  const double pi = std::acos(-1.0);
  for (int i = 0; i <= rings; ++i) {
    for (int j = 0; j < columns; ++j) {
      const double polar = pi * i / rings, azimuth = 2 * pi * j / columns;
      ball.vertices_base_m.push_back({kBall_m * std::sin(polar) * std::cos(azimuth),
                                      kBall_m * std::sin(polar) * std::sin(azimuth), kBall_m * (std::cos(polar) - 1)});
    }
  }
  const auto at = [&](int i, int j) { return static_cast<std::uint32_t>(i * columns + j % columns); };
  for (int i = 0; i < rings; ++i) {
    for (int j = 0; j < columns; ++j) {
      ball.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      ball.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  }
  ball.triangle_material.assign(ball.triangles.size(), 0);
  ball.name = "ball of " + std::to_string(ball.triangles.size());
  return ball;
}

// A tip in the real tick; the stability rule is disabled, so that springs have their nominal stiffness.
class RubbingTip {
 public:
  RubbingTip(const haptics::InputObject& object, const FrictionPair& friction, double stiffness_N_m) {
    haptics::SceneInput input;
    input.objects.push_back(object);
    haptics::Material material;
    material.stiffness_N_m = stiffness_N_m;
    material.static_friction = friction.at_rest;
    material.dynamic_friction = friction.sliding;
    input.materials.push_back(material);
    haptics::BuildReport report;
    auto built = haptics::BuildScene(input, report);
    if (built.ok()) scene_ = std::move(*built);
    config_.delay_s = config_.coil_lag_s = config_.predict_max_s = config_.ramp_s = 0;
    config_.stiffness_max_N_m = 1000;
    input_.tracked = true;
    input_.limit.valid = true;
    input_.limit.ampere_per_newton = {5, 0, 0, 0, 5, 0, 0, 0, 5};
    input_.limit.current_max_A = {150, 150, 150};
    input_.limit.force_max_N = 20;
    haptics::EnterScene(scene_, state_);
  }

  const haptics::Output& MoveTo(const Vec3& tip) {
    if (state_.was_tracked) {
      input_.velocity_base_m_s = (1 / base::kTickPeriod_s) * (tip - input_.device_point_base_m);
    }
    input_.device_point_base_m = tip;
    haptics::Step(config_, scene_, input_, state_, output_);
    return output_;
  }
  bool sticks() const { return state_.contacts[0].active && state_.contacts[0].sticking; }
  const haptics::ContactState& contact() const { return state_.contacts[0]; }

 private:
  haptics::Scene scene_;
  haptics::Config config_;
  haptics::Input input_;
  haptics::State state_;
  haptics::Output output_;
};

class Draw {
 public:
  explicit Draw(std::uint64_t seed) : engine_(seed) {}
  double Uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  Vec3 Noise(double sigma) {
    std::normal_distribution<double> normal(0, sigma);
    return {normal(engine_), normal(engine_), normal(engine_)};
  }

 private:
  std::mt19937_64 engine_;
};

// Presses, then drags at a constant depth until it slips and beyond: tangential over normal force at breakaway and
// while it slides.
FrictionPair DragAcross(const haptics::InputObject& object, const FrictionPair& friction, bool ball, Draw& draw) {
  RubbingTip tip(object, friction, 800);
  const double depth_m = draw.Uniform(3e-4, 1.5e-3), azimuth = draw.Uniform(0, 6.28),
               speed_m_s = draw.Uniform(2e-4, 2e-3);
  const auto place = [&](double way_m, double height_m) -> Vec3 {
    const Vec3 along{std::cos(azimuth), std::sin(azimuth), 0};
    if (!ball) return way_m * along + Vec3{0, 0, height_m};
    const double angle = way_m / kBall_m, r = kBall_m + height_m;
    return r * std::sin(angle) * along + Vec3{0, 0, r * std::cos(angle) - kBall_m};
  };
  for (int k = 0; k < 400; ++k) tip.MoveTo(place(0, 1e-3 - (1e-3 + depth_m) * std::min(1.0, k / 300.0)));
  FrictionPair measured{0, 0};
  int slides = 0;
  const double way_m = 0.012;
  for (double x = 0; x < way_m; x += speed_m_s * base::kTickPeriod_s) {
    const haptics::Output& out = tip.MoveTo(place(x, -depth_m));
    if (out.contact_count != 1) continue;
    const double ratio = out.contacts[0].tangential_force_N / out.contacts[0].normal_force_N;
    if (slides == 0 && tip.sticks()) {
      measured.at_rest = ratio;
    } else if (!tip.sticks()) {
      measured.sliding += ratio;
      ++slides;
    }
  }
  measured.sliding /= std::max(1, slides);
  return measured;
}

nlohmann::ordered_json ConeRow(const haptics::InputObject& object, bool ball, int trials, Draw& draw) {
  double rest_pct = 0, slide_pct = 0, least = 1e9, most = 0;
  for (int k = 0; k < trials; ++k) {
    const double at_rest = draw.Uniform(0.1, 1.5);
    const FrictionPair asked{at_rest, draw.Uniform(0.05, at_rest)};
    const FrictionPair measured = DragAcross(object, asked, ball, draw);
    rest_pct = std::max(rest_pct, 100 * std::abs(measured.at_rest / asked.at_rest - 1));
    slide_pct = std::max(slide_pct, 100 * std::abs(measured.sliding / asked.sliding - 1));
    least = std::min(least, asked.at_rest);
    most = std::max(most, asked.at_rest);
  }
  return {{"study", "cone"},
          {"body", object.name},
          {"trials", trials},
          {"static_min", least},
          {"static_max", most},
          {"breakaway_error_pct_max", rest_pct},
          {"sliding_error_pct_max", slide_pct}};
}

// A mass pressed onto a surface and pulled along by a spring whose end moves steadily.
struct Slider {
  double mass_kg = 0.1, spring_N_m = 60, damping_Ns_m = 1, speed_m_s = 0.004, normal_N = 0.8;
  FrictionPair friction{0.6, 0.3};
};

struct StickSlip {
  double period_s = 0, drop_N = 0;
  int cycles = 0;
};

// Mean period and fall of the spring's force, from its maxima and minima after the first cycles.
class CycleMeter {
 public:
  void Add(double t_s, double force_N, bool slips) {
    if (slips && !slipped_) {
      if (starts_++ == kSkipped) first_s_ = t_s;
      last_s_ = t_s;
      if (starts_ > kSkipped + 1) sum_drop_N_ += top_N_ - bottom_N_;
      top_N_ = bottom_N_ = force_N;
    }
    slipped_ = slips;
    bottom_N_ = std::min(bottom_N_, force_N);
  }
  StickSlip Result() const {
    const int cycles = starts_ - 1 - kSkipped;
    if (cycles < 1) return {};
    return {(last_s_ - first_s_) / cycles, sum_drop_N_ / cycles, cycles};
  }

 private:
  static constexpr int kSkipped = 2;
  bool slipped_ = false;
  int starts_ = 0;
  double first_s_ = 0, last_s_ = 0, top_N_ = 0, bottom_N_ = 0, sum_drop_N_ = 0;
};

// Coulomb's law itself: stuck while the spring's force is within the cone, else sliding until the velocity turns.
StickSlip Coulomb(const Slider& s, double duration_s) {
  constexpr double kStep_s = 1e-6;
  double x = 0, v = 0;
  bool slides = false;
  CycleMeter meter;
  for (double t = 0; t < duration_s; t += kStep_s) {
    const double pull_N = s.spring_N_m * (s.speed_m_s * t - x);
    if (!slides && pull_N > s.friction.at_rest * s.normal_N) slides = true;
    meter.Add(t, pull_N, slides);
    if (!slides) continue;
    v += kStep_s * (pull_N - s.damping_Ns_m * v - s.friction.sliding * s.normal_N) / s.mass_kg;
    x += kStep_s * v;
    if (v <= 0) slides = false, v = 0;
  }
  return meter.Result();
}

// The same mass on the rendered surface: the contact is a spring of `stiffness_N_m`, evaluated once per tick.
StickSlip Rendered(const Slider& s, const haptics::InputObject& object, double stiffness_N_m, double duration_s) {
  constexpr int kSubsteps = 100;
  RubbingTip tip(object, s.friction, stiffness_N_m);
  const double depth_m = s.normal_N / stiffness_N_m, h = base::kTickPeriod_s / kSubsteps;
  for (int k = 0; k < 100; ++k) tip.MoveTo({0, 0, 1e-3 - (1e-3 + depth_m) * k / 99.0});
  double x = 0, v = 0;
  CycleMeter meter;
  for (int tick = 0; tick * base::kTickPeriod_s < duration_s; ++tick) {
    const double force_N = tip.MoveTo({x, 0, -depth_m}).force_base_N.x;
    const double t = tick * base::kTickPeriod_s;
    meter.Add(t, s.spring_N_m * (s.speed_m_s * t - x), !tip.sticks());
    for (int k = 0; k < kSubsteps; ++k) {
      const double pull_N = s.spring_N_m * (s.speed_m_s * (t + k * h) - x);
      v += h * (pull_N - s.damping_Ns_m * v + force_N) / s.mass_kg;
      x += h * v;
    }
  }
  return meter.Result();
}

nlohmann::ordered_json StickSlipRow(const haptics::InputObject& object, double stiffness_N_m, const Slider& slider,
                                    double duration_s) {
  const StickSlip law = Coulomb(slider, duration_s), ours = Rendered(slider, object, stiffness_N_m, duration_s);
  return {{"table", "stick-slip"},
          {"body", object.name},
          {"stiffness_N_m", stiffness_N_m},
          {"static_friction", slider.friction.at_rest},
          {"dynamic_friction", slider.friction.sliding},
          {"cycles", ours.cycles},
          {"period_ms", 1e3 * ours.period_s},
          {"coulomb_period_ms", 1e3 * law.period_s},
          {"period_error_pct", 100 * (ours.period_s / law.period_s - 1)},
          {"drop_N", ours.drop_N},
          {"coulomb_drop_N", law.drop_N},
          {"drop_error_pct", 100 * (ours.drop_N / law.drop_N - 1)}};
}

// Rests in stick at a share of the cone, with noise on the tip: how far the anchor wanders.
nlohmann::ordered_json DriftRow(const haptics::InputObject& object, double load, double noise_m, std::uint64_t ticks,
                                Draw& draw) {
  const FrictionPair friction{0.5, 0.4};
  const double depth_m = 1e-3, stiffness_N_m = 500;
  RubbingTip tip(object, friction, stiffness_N_m);
  for (int k = 0; k < 200; ++k) tip.MoveTo({0, 0, 1e-3 - (1e-3 + depth_m) * std::min(1.0, k / 100.0)});
  const double pulled_m = load * friction.at_rest * depth_m;
  for (int k = 0; k < 200; ++k) tip.MoveTo({pulled_m * k / 199.0, 0, -depth_m});
  const haptics::ContactState start = tip.contact();
  double drift_m = 0;
  std::uint64_t slips = 0;
  for (std::uint64_t k = 0; k < ticks; ++k) {
    tip.MoveTo(Vec3{pulled_m, 0, -depth_m} + draw.Noise(noise_m));
    slips += tip.sticks() ? 0 : 1;
    drift_m = std::max(drift_m, base::Norm(tip.contact().anchor_m - start.anchor_m));
  }
  return {{"table", "drift"}, {"body", object.name}, {"load_of_cone", load},     {"noise_mm", 1e3 * noise_m},
          {"ticks", ticks},   {"slips", slips},      {"drift_um", 1e6 * drift_m}};
}

}  // namespace

base::Result<BenchRows> BenchFriction(const BenchOptions& options) {
  Draw draw(options.seed);
  BenchRows rows;
  const haptics::InputObject coarse = PlateOf(1), fine = PlateOf(100), ball = BallOf(120);
  const int trials = options.quick ? 5 : 100;
  rows.push_back(ConeRow(coarse, false, trials, draw));
  rows.push_back(ConeRow(fine, false, trials, draw));
  rows.push_back(ConeRow(ball, true, trials, draw));
  const double duration_s = options.quick ? 5 : 30;
  for (const FrictionPair& friction : {FrictionPair{0.6, 0.3}, FrictionPair{0.5, 0.4}, FrictionPair{0.9, 0.6}}) {
    Slider slider;
    slider.friction = friction;
    rows.push_back(StickSlipRow(fine, 400, slider, duration_s));
    rows.push_back(StickSlipRow(fine, 1000, slider, duration_s));
  }
  const std::uint64_t ticks = options.ticks > 0 ? options.ticks : (options.quick ? 10'000 : 1'000'000);
  rows.push_back(DriftRow(fine, 0.9, 0, ticks, draw));
  rows.push_back(DriftRow(fine, 0.7, 1e-5, ticks, draw));
  rows.push_back(DriftRow(ball, 0.7, 1e-5, ticks, draw));
  return rows;
}

}  // namespace omni::bench
