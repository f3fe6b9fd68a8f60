// For any input: the force that the currents really make, by the twin's fields, stays within the device's limit,
// rises no faster than the tick allows, and is zero on any doubt.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <memory>

#include "service/config/files/device_file.h"
#include "service/haptics/scene/scene.h"
#include "service/loop/realtime.h"
#include "service/loop/tick_config.h"
#include "tests/support/rig/hostile_stream.h"
#include "tests/support/touch/scenario.h"

namespace omni::test {
namespace test_loop_limits {

constexpr double kForceMax_N = 2;
constexpr double kRise_N_s = 850;
constexpr double kModelTolerance = 0.01;  // of the tick's fields against the twin's
constexpr int kBridgeTicks = 12;          // a pose may be held for ten scans

// Distance of `force` from the segment between `from` and zero, which falling alone can reach.
double Growth_N(const base::Vec3& force, const base::Vec3& from) {
  const double size2 = Dot(from, from);
  const double share = size2 > 0 ? std::clamp(Dot(force, from) / size2, 0.0, 1.0) : 0.0;
  return Norm(force - share * from);
}

bool Drives(const sim::CoilArray& current_A) {
  return std::any_of(current_A.begin(), current_A.end(), [](double i) { return i != 0; });
}

struct Worst {
  double commanded_N = 0, commanded_rise_N_s = 0;
  double force_N = 0, rise_N_s = 0, growth_N_s = 0;  // at the pose that the tick knows
  double true_N = 0;                                 // at the pen's own pose, while a hand could have moved it there
  int not_finite = 0, over_current = 0, doubts_with_current = 0, driven = 0, ticks = 0;

  void Add(const Worst& w) {
    commanded_N = std::max(commanded_N, w.commanded_N);
    commanded_rise_N_s = std::max(commanded_rise_N_s, w.commanded_rise_N_s);
    force_N = std::max(force_N, w.force_N);
    rise_N_s = std::max(rise_N_s, w.rise_N_s);
    growth_N_s = std::max(growth_N_s, w.growth_N_s);
    true_N = std::max(true_N, w.true_N);
    not_finite += w.not_finite;
    over_current += w.over_current;
    doubts_with_current += w.doubts_with_current;
    driven += w.driven;
    ticks += w.ticks;
  }
};

// Boxes above and beside the hull, so that a pen anywhere is soon in one of them.
haptics::Scene HardScene(double out_m) {
  haptics::SceneInput input;
  input.name = "boxes";
  input.materials.push_back({.stiffness_N_m = 2000, .damping_Ns_m = 1});
  const double at = out_m - 0.005;
  input.objects.push_back(Box({0, 0, at}, {0.02, 0.02, 0.005}, 3));
  for (const double side : {-1.0, 1.0}) {
    input.objects.push_back(Box({side * at, 0, 0.03}, {0.005, 0.03, 0.03}, 3));
    input.objects.push_back(Box({0, side * at, 0.03}, {0.03, 0.005, 0.03}, 3));
  }
  haptics::BuildReport report;
  return std::move(haptics::BuildScene(input, report).value());
}

class HostileRun {
 public:
  explicit HostileRun(std::uint64_t seed)
      : random_(seed),
        rig_(config::DefaultDevice(),
             {.seed = seed, .sizes = sim::NoImperfections(), .noise = sim::NoiseMode::kLowPower}),
        config_(loop::MakeTickConfig(config::DefaultDevice(), rig_.ExactCalibration())),
        pen_(rig_, random_),
        commands_(random_),
        scans_(rig_, random_) {
    loop::EnterScene(first_, 1, *state_);
  }

  void Tick() {
    const std::int64_t period_ns = DrawPeriod_ns(random_);
    now_ns_ += period_ns;
    pen_.Move(1e-9 * static_cast<double>(std::min<std::int64_t>(period_ns, 10'000'000)));
    base::HallScan scan = rig_.Scan(pen_.pose(), output_->currents.current_A, random_);
    scan.t_ns = now_ns_;
    const bool was_good = scans_.good();
    scans_.Spoil(scan);
    const loop::Commands& commands = commands_.Next(now_ns_, output_->tool.device_point_base_m);
    last_A_ = output_->currents.current_A;
    const base::Vec3 last_commanded_N = output_->wrench.force_N;
    const haptics::Scene& scene = state_->scene_generation == 1 ? first_ : second_;
    loop::Tick(config_, scan, commands, scene, *state_, *output_, {.samples = commands_.samples()});
    if (output_->wants_scene) {
      loop::EnterScene(commands.scene_generation == 1 ? first_ : second_, commands.scene_generation, *state_);
    }
    // Where a stamp may lie, a tick may take it for a whole one.
    const bool honest = was_good && scans_.good();
    const double period_s = honest ? 1e-9 * static_cast<double>(period_ns) : base::kTickPeriod_s;
    Judge(std::min(period_s, base::kTickPeriod_s), last_commanded_N);
  }

  const Worst& worst() const { return worst_; }

 private:
  void Judge(double dt_s, const base::Vec3& last_commanded_N) {
    ++worst_.ticks;
    const sim::CoilArray& current_A = output_->currents.current_A;
    for (const double i : current_A) {
      worst_.not_finite += std::isfinite(i) ? 0 : 1;
      worst_.over_current += std::abs(i) <= 15 ? 0 : 1;
    }
    const double commanded_N = Norm(output_->wrench.force_N);
    worst_.commanded_N = std::max(worst_.commanded_N, commanded_N);
    worst_.commanded_rise_N_s = std::max(worst_.commanded_rise_N_s, (commanded_N - Norm(last_commanded_N)) / dt_s);
    const bool tracked = output_->tool.status == base::TrackingStatus::kTracking;
    lost_ticks_ = tracked ? 0 : lost_ticks_ + 1;
    const bool doubt = output_->gate == 0 || lost_ticks_ > kBridgeTicks || commanded_N == 0 ||
                       output_->tool.status == base::TrackingStatus::kAbsent;
    worst_.doubts_with_current += doubt && Drives(current_A) ? 1 : 0;
    JudgeForce(dt_s);
  }

  void JudgeForce(double dt_s) {
    const sim::CoilArray& current_A = output_->currents.current_A;
    const sim::MagnetPose known{output_->tool.position_base_m, output_->tool.axis_base};
    const bool was_outside = is_outside_;
    is_outside_ = Norm(known.centre_base_m) > rig_.device().hull_radius_m;  // a wrong pose may be anywhere
    if (!is_outside_) return;
    if (!Drives(current_A) && !Drives(last_A_)) {
      last_N_ = {};
      return;
    }
    ++worst_.driven;
    const sim::ForceMap map = rig_.truth().ForcesAt(known);
    const base::Vec3 coils_N = map.CoilForce(current_A);
    if (Drives(current_A) && was_outside) {
      worst_.force_N = std::max(worst_.force_N, Norm(map.Force(current_A, {})));
      worst_.rise_N_s = std::max(worst_.rise_N_s, (Norm(coils_N) - Norm(last_N_)) / dt_s);
      worst_.growth_N_s = std::max(worst_.growth_N_s, Growth_N(coils_N, map.CoilForce(last_A_)) / dt_s);
    }
    last_N_ = coils_N;
    const bool plausible = pen_.pose() != nullptr && pen_.calm_ticks() > 50 && scans_.good() && lost_ticks_ == 0;
    if (!plausible) return;
    const base::Vec3 true_N = rig_.truth().ForcesAt(*pen_.pose()).Force(current_A, {});
    worst_.true_N = std::max(worst_.true_N, Norm(true_N));
  }

  sim::Random random_;
  sim::Rig rig_;
  const loop::TickConfig config_;
  HostilePen pen_;
  HostileCommands commands_;
  HostileScans scans_;
  const haptics::Scene first_ = HardScene(0.055), second_ = HardScene(0.062);
  std::unique_ptr<loop::LoopState> state_ = std::make_unique<loop::LoopState>();
  std::unique_ptr<loop::TickOutput> output_ = std::make_unique<loop::TickOutput>();
  std::int64_t now_ns_ = 1'000'000'000;
  sim::CoilArray last_A_{};
  base::Vec3 last_N_;
  bool is_outside_ = true;
  int lost_ticks_ = 0;
  Worst worst_;
};

TEST(LoopLimits, TrueForceStaysWithinForceAndRiseLimits) {
  loop::FlushDenormals();
  Worst worst;
  for (std::uint64_t seed = 1; seed <= 8; ++seed) {
    HostileRun run(seed);
    for (int i = 0; i < 10'000; ++i) run.Tick();
    worst.Add(run.worst());
  }
  std::printf(
      "%d ticks, %d with current: commanded %.4f N, rise %.1f N/s; made %.4f N, rise %.1f N/s, growth %.1f N/s; "
      "at the pen's own pose %.4f N; currents despite doubt in %d ticks\n",
      worst.ticks, worst.driven, worst.commanded_N, worst.commanded_rise_N_s, worst.force_N, worst.rise_N_s,
      worst.growth_N_s, worst.true_N, worst.doubts_with_current);
  EXPECT_GT(worst.driven, worst.ticks / 10);
  EXPECT_EQ(worst.not_finite, 0);
  EXPECT_EQ(worst.over_current, 0);
  EXPECT_EQ(worst.doubts_with_current, 0);
  EXPECT_LE(worst.commanded_N, kForceMax_N * (1 + 1e-9));
  EXPECT_LE(worst.commanded_rise_N_s, kRise_N_s * (1 + 1e-9));
  EXPECT_LE(worst.force_N, kForceMax_N * (1 + kModelTolerance));
  EXPECT_LE(worst.rise_N_s, kRise_N_s * (1 + kModelTolerance));
  EXPECT_LE(worst.growth_N_s, kRise_N_s * (1 + kModelTolerance));
}

}  // namespace test_loop_limits
}  // namespace omni::test
