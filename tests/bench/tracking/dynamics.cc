// omni-bench dynamics: a pen that starts, stops, trembles and rests, tracked on bases calibrated on site. Simulated by
// the digital twin, with whose own path the published pose is compared.
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <memory>
#include <numbers>
#include <string>
#include <vector>

#include "service/sim/fields/random.h"
#include "service/sim/fields/vec3.h"
#include "service/sim/twin/loopback.h"
#include "service/tools/common/row_table.h"
#include "service/tracker/tracker.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/room_conditions.h"
#include "tests/bench/tracking/nees.h"

namespace omni::bench {
namespace {

constexpr std::size_t kRigs = 10, kDashes = 102;  // of each rig
constexpr double kSpeed_m_s = 0.5, kRest_s = 0.3, kGlide_s = 0.06;
constexpr double kSettle_s = 2;              // before anything counts
constexpr double kStop_s = 0.15;             // of a stop, that counts
constexpr double kLong_s = 20, kPart_s = 1;  // of a tremor or a rest; its trials
constexpr double kTremor_m = 2e-4, kTremor_Hz = 10;
constexpr std::uint64_t kPlaces = 8;  // of tremors, for a quarter as long

constexpr std::array<double, 2> kRadii_m{0.055, 0.09};
constexpr std::array<double, 3> kAccelerations_m_s2{5, 20, 100};

// To and fro on an arc about the base's top with a constant axis: rests, starts, glides, stops.
class Dashes final : public sim::PenMotion {
 public:
  Dashes(double radius_m, double acceleration_m_s2, double azimuth_rad)
      : radius_m_(radius_m),
        ramp_s_(kSpeed_m_s / acceleration_m_s2),
        side_{std::cos(azimuth_rad), std::sin(azimuth_rad), 0} {}

  double period_s() const { return kRest_s + 2 * ramp_s_ + kGlide_s; }
  // Of the current or next dash: negative while the pen rests before it.
  double SinceStart_s(double t_s) const { return (Dashed(t_s) - std::floor(Dashed(t_s))) * period_s() - kRest_s; }
  double SinceStop_s(double t_s) const { return SinceStart_s(t_s) - ramp_s_ - kGlide_s; }
  std::size_t DashAt(double t_s) const { return static_cast<std::size_t>(Dashed(t_s)); }

  State StateAt(double t_s) const noexcept override {
    const double sense = DashAt(t_s) % 2 == 0 ? 1 : -1, rate_m_s = sense * Speed_m_s(t_s);
    const double angle = sense * (Gone_m(t_s) - kSpeed_m_s * (ramp_s_ + kGlide_s) / 2) / radius_m_;
    const base::Vec3 up{0, 0, 1};
    return {{radius_m_ * (std::sin(angle) * side_ + std::cos(angle) * up), {0, 0, -1}},
            rate_m_s * (std::cos(angle) * side_ - std::sin(angle) * up)};
  }

 private:
  double Dashed(double t_s) const { return std::max(0.0, (t_s - kSettle_s) / period_s()); }
  double Speed_m_s(double t_s) const {
    const double share = std::min(SinceStart_s(t_s), ramp_s_ - SinceStop_s(t_s)) / ramp_s_;
    return kSpeed_m_s * std::clamp(share, 0.0, 1.0);
  }
  double Gone_m(double t_s) const {
    const double started_s = std::clamp(SinceStart_s(t_s), 0.0, ramp_s_);
    const double glided_s = std::clamp(SinceStart_s(t_s) - ramp_s_, 0.0, kGlide_s);
    const double stopping_s = std::clamp(SinceStop_s(t_s), 0.0, ramp_s_);
    const double half_m_s2 = kSpeed_m_s / ramp_s_ / 2;
    return half_m_s2 * started_s * started_s + kSpeed_m_s * (glided_s + stopping_s) -
           half_m_s2 * stopping_s * stopping_s;
  }

  double radius_m_, ramp_s_;
  base::Vec3 side_;
};

// A sine of that amplitude in any direction at any place above the base; 0: rest.
class Trembling final : public sim::PenMotion {
 public:
  Trembling(double radius_m, double amplitude_m, std::uint64_t seed) : amplitude_m_(amplitude_m) {
    sim::Random random(seed);
    const auto draw = [&] { return base::Vec3{random.Normal(), random.Normal(), random.Normal()}; };
    const base::Vec3 aside = draw();
    direction_ = Normalized(draw());
    at_.pose.centre_base_m = radius_m * base::Normalized({0.3 * aside.x, 0.3 * aside.y, 1});
    at_.pose.axis_base = {0, 0, -1};
  }
  const base::Vec3& direction() const { return direction_; }
  static double Phase(double t_s) { return 2 * std::numbers::pi * kTremor_Hz * t_s; }

  State StateAt(double t_s) const noexcept override {
    State state = at_;
    state.pose.centre_base_m = at_.pose.centre_base_m + amplitude_m_ * std::sin(Phase(t_s)) * direction_;
    state.velocity_base_m_s = 2 * std::numbers::pi * kTremor_Hz * amplitude_m_ * std::cos(Phase(t_s)) * direction_;
    return state;
  }

 private:
  base::Vec3 direction_;
  double amplitude_m_;
  State at_;
};

struct CalibratedBase {
  base::DeviceGeometry device;
  base::TruthParameters truth;
  tracker::Config config;
  std::uint64_t seed = 0;
  double azimuth_rad = 0;
};

struct Sample {
  double t_s = 0;  // of the pose, since the run began
  sim::MagnetPose truth;
  base::ToolState tool;

  base::Vec3 error_m() const { return tool.position_base_m - truth.centre_base_m; }
};

// Results of one motion, for each trial; the sum of the NEES is over `ticks`.
struct Trials {
  std::vector<double> error_mm, speed_m_s, gain, delay_ms, scatter_mm;
  double nees = 0;
  std::size_t ticks = 0, lost_ticks = 0;

  void Add(const Trials& more) {
    const auto append = [](const std::vector<double>& from, std::vector<double>& to) {
      to.insert(to.end(), from.begin(), from.end());
    };
    append(more.error_mm, error_mm);
    append(more.speed_m_s, speed_m_s);
    append(more.gain, gain);
    append(more.delay_ms, delay_ms);
    append(more.scatter_mm, scatter_mm);
    nees += more.nees;
    ticks += more.ticks;
    lost_ticks += more.lost_ticks;
  }
  void See(const Sample& sample) {
    nees += Nees(sample.truth, sample.tool.position_base_m, sample.tool.axis_base, sample.tool.covariance);
    ++ticks;
  }
  // The worst of a trial.
  void See(const Sample& sample, std::size_t trial) {
    See(sample);
    error_mm.resize(std::max(error_mm.size(), trial + 1));
    speed_m_s.resize(error_mm.size());
    error_mm[trial] = std::max(error_mm[trial], 1e3 * base::Norm(sample.error_m()));
    speed_m_s[trial] = std::max(speed_m_s[trial], base::Norm(sample.tool.velocity_base_m_s));
  }
};

// Returns the number of ticks that were not tracked; those are not used.
template <typename Use>
std::size_t Follow(const CalibratedBase& base, const std::shared_ptr<const sim::PenMotion>& motion, double duration_s,
                   const Use& use) {
  sim::PlantOptions plant{.seed = base.seed};
  plant.truth = base.truth;
  plant.motion = motion;
  sim::Loopback loopback(base.device, plant);
  tracker::State state;
  Sample sample;
  base::HallScan scan;
  std::size_t lost = 0;
  for (;;) {
    loopback.Tick(scan);
    tracker::Update(base.config, scan, state, sample.tool);
    sample.t_s = 1e-9 * static_cast<double>(scan.t_ns - sim::Loopback::kClockStart_ns);
    if (sample.t_s >= kSettle_s + duration_s) return lost;
    if (sample.t_s < kSettle_s) continue;
    if (sample.tool.status != base::TrackingStatus::kTracking) {
      ++lost;
      continue;
    }
    sample.truth = motion->StateAt(sample.t_s).pose;
    use(sample);
  }
}

// Starts, until the glide ends; stops.
std::array<Trials, 2> Dash(const CalibratedBase& base, double radius_m, double acceleration_m_s2, std::size_t dashes) {
  const auto motion = std::make_shared<Dashes>(radius_m, acceleration_m_s2, base.azimuth_rad);
  std::array<Trials, 2> trials;
  trials[0].lost_ticks =
      Follow(base, motion, static_cast<double>(dashes) * motion->period_s() + kRest_s, [&](const Sample& sample) {
        // A stop goes on while the pen rests before the next dash.
        const bool rests = motion->SinceStart_s(sample.t_s) < 0;
        const std::size_t dash = motion->DashAt(sample.t_s);
        if (rests && dash == 0) return;
        const double since_stop_s = motion->SinceStop_s(sample.t_s) + (rests ? motion->period_s() : 0);
        const std::size_t trial = rests ? dash - 1 : dash;
        if (trial >= dashes || since_stop_s > kStop_s) return;
        trials[since_stop_s < 0 ? 0 : 1].See(sample, trial);
      });
  return trials;
}

//   c = 2 / (n a) sum p_k exp(-i phase_k) with p along the sine: its gain is |c|, and its lag is arg(i c)
Trials Tremble(const CalibratedBase& base, double radius_m, double duration_s, std::uint64_t place) {
  const auto motion = std::make_shared<Trembling>(radius_m, kTremor_m, 100 * base.seed + place);
  const base::Vec3 middle_m = motion->StateAt(0).pose.centre_base_m;
  std::complex<double> sum;
  Trials trials;
  trials.lost_ticks = Follow(base, motion, duration_s, [&](const Sample& sample) {
    trials.See(sample);
    sum += base::Dot(sample.tool.position_base_m - middle_m, motion->direction()) *
           std::polar(1.0, -Trembling::Phase(sample.t_s));
  });
  const std::complex<double> c = 2 / (static_cast<double>(trials.ticks) * kTremor_m) * sum;
  trials.gain = {std::abs(c)};
  trials.delay_ms = {-1e3 * std::arg(std::complex<double>(0, 1) * c) / Trembling::Phase(1)};
  return trials;
}

// rms about its own mean, of each second.
Trials LieStill(const CalibratedBase& base, double radius_m, double duration_s) {
  const auto motion = std::make_shared<Trembling>(radius_m, 0, base.seed);
  std::vector<base::Vec3> part;
  Trials trials;
  trials.lost_ticks = Follow(base, motion, duration_s, [&](const Sample& sample) {
    trials.See(sample, static_cast<std::size_t>((sample.t_s - kSettle_s) / kPart_s));
    part.push_back(sample.error_m());
    if (static_cast<double>(part.size()) < kPart_s / base::kTickPeriod_s) return;
    base::Vec3 mean;
    double square = 0;
    for (const base::Vec3& e : part) mean = mean + (1.0 / static_cast<double>(part.size())) * e;
    for (const base::Vec3& e : part) square += base::Dot(e - mean, e - mean);
    trials.scatter_mm.push_back(1e3 * std::sqrt(square / static_cast<double>(part.size())));
    part.clear();
  });
  return trials;
}

struct Measured {
  std::string motion;
  double radius_m = 0;
  Trials trials;
};

std::vector<Measured> AllOf(const CalibratedBase& base, bool quick) {
  const std::size_t dashes = quick ? 4 : kDashes;
  const double long_s = quick ? 2 : kLong_s;
  std::vector<Measured> all;
  for (const double radius_m : kRadii_m) {
    for (const double a_m_s2 : kAccelerations_m_s2) {
      const auto [starts, stops] = Dash(base, radius_m, a_m_s2, dashes);
      const std::string name = std::to_string(static_cast<int>(a_m_s2));
      all.push_back({"start-" + name, radius_m, starts});
      all.push_back({"stop-" + name, radius_m, stops});
    }
    Trials tremors;
    for (std::uint64_t place = 0; place < (quick ? 1 : kPlaces); ++place) {
      tremors.Add(Tremble(base, radius_m, long_s / 4, place));
    }
    all.push_back({"tremor-10Hz", radius_m, tremors});
    all.push_back({"rest", radius_m, LieStill(base, radius_m, long_s)});
  }
  return all;
}

// null: not defined for this motion.
nlohmann::ordered_json Quantile(const std::vector<double>& values, double share) {
  return values.empty() ? nlohmann::ordered_json() : nlohmann::ordered_json(tools::Quantile(values, share));
}

nlohmann::ordered_json RowOf(bool room, const Measured& measured) {
  const Trials& of = measured.trials;
  return {{"room", room},
          {"motion", measured.motion},
          {"radius_mm", 1e3 * measured.radius_m},
          {"trials", std::max(of.error_mm.size(), of.gain.size())},
          {"p95_mm", Quantile(of.error_mm, 0.95)},
          {"max_mm", Quantile(of.error_mm, 1)},
          {"peak_speed_median_m_s", Quantile(of.speed_m_s, 0.5)},
          {"peak_speed_p95_m_s", Quantile(of.speed_m_s, 0.95)},
          {"gain", Quantile(of.gain, 0.5)},
          {"delay_ms", Quantile(of.delay_ms, 0.5)},
          {"scatter_mm", Quantile(of.scatter_mm, 0.5)},
          {"nees_per_dof", of.ticks > 0 ? of.nees / static_cast<double>(of.ticks) : 0},
          {"lost_ticks", of.lost_ticks}};
}

}  // namespace

base::Result<BenchRows> BenchDynamics(const BenchOptions& options) {
  const std::size_t rigs = options.quick ? 1 : kRigs;
  const base::DeviceGeometry device = FastDevice();
  BenchRows rows;
  for (const bool in_room : {false, true}) {
    const RoomCondition condition{.name = in_room ? "room" : "ideal", .ideal = !in_room};
    std::vector<std::vector<Measured>> of_rig(rigs);
    const auto follow = [&](std::size_t r, std::uint64_t seed, const loop::TickConfig& config) {
      const double azimuth_rad = sim::Random(seed).Uniform(-std::numbers::pi, std::numbers::pi);
      of_rig[r] = AllOf({device, RoomOf(condition), config.tracker, seed, azimuth_rad}, options.quick);
    };
    if (auto error = OnRigs(condition, device, rigs, 1000 * options.seed, follow)) return *error;
    for (std::size_t m = 0; m < of_rig[0].size(); ++m) {
      Measured all = of_rig[0][m];
      for (std::size_t r = 1; r < rigs; ++r) all.trials.Add(of_rig[r][m].trials);
      rows.push_back(RowOf(in_room, all));
    }
  }
  return rows;
}

}  // namespace omni::bench
