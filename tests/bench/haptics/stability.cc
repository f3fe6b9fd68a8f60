// omni-bench stability: walls that are stable for a simulated hand, and the stiffness that the renderer allows.
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <tuple>

#include "service/base/limits.h"
#include "tests/bench/haptics/closed_loop.h"
#include "tests/bench/harness/bench.h"
#include "tests/support/touch/virtual_wall.h"

namespace omni::bench {
namespace {

using test::PressWall;
using test::RmsAboutLine;
using test::WallHand;
using test::WallLoop;
using test::WallRule;
using test::WallRun;

constexpr double kAsked_N_m = 6000;    // by the material where the rule applies
constexpr std::size_t kSecond = 1000;  // ticks
constexpr double kLeast_m = 1e-6;      // movement below is none
constexpr double kEnergyMax_mJ = 10, kBuzzMax_mN = 30, kBuzzNoise_mm = 0.1;
constexpr double kBuzzFrom_Hz = 30;

struct Grid {
  std::vector<double> stiffness_N_m, delay_ms, damping_Ns_m, mass_kg, noise_mm;
};

Grid GridFor(bool quick) {
  if (quick) return {{50, 500, 6000}, {1, 5}, {1}, {0.05, 0.2}, {0, 0.1}};
  return {{20, 50, 100, 200, 400, 800, 1600, 3000, 6000},
          {0, 0.5, 1, 2, 5, 10, 25},
          {1, 2, 5},
          {0.05, 0.1, 0.2},
          {0, 0.02, 0.1, 0.3, 1}};
}

struct Point {
  double delay_ms, damping_Ns_m, mass_kg, noise_mm;
  double late_ms = 0;  // true delay beyond the one that haptics is given
};

struct Outcome {
  double stiffness_N_m = 0, predict_ms = 0;
  bool limit_cycle = false;
  double energy_mJ = 0, buzz_mN = 0;
  double gain = 1;  // left by a watch

  bool Good(double noise_mm) const {
    return !limit_cycle && energy_mJ < kEnergyMax_mJ && (noise_mm > kBuzzNoise_mm || buzz_mN < kBuzzMax_mN);
  }
};

class Sweep {
 public:
  explicit Sweep(std::uint64_t seed) : seed_(seed) {}

  Outcome Run(const Point& p, WallRule rule, double stiffness_N_m) {
    const WallHand hand{p.mass_kg, p.damping_Ns_m};
    const WallLoop loop{.delay_s = 1e-3 * p.delay_ms, .late_s = 1e-3 * p.late_ms, .noise_m = 1e-3 * p.noise_mm};
    const WallRun held = PressWall(hand, loop, {}, rule, stiffness_N_m, seed_);
    const WallRun pressed = PressWall(hand, loop, {.hold_s = 1, .release = true}, rule, stiffness_N_m, seed_);
    const auto& x = held.measured_m;
    const double last_m = RmsAboutLine(x, x.size() - kSecond, x.size());
    const double before_m = RmsAboutLine(x, x.size() - 2 * kSecond, x.size() - kSecond);
    const bool cycles = last_m > 2 * std::max(kLeast_m, Unloaded_m(p)) && last_m >= 0.8 * before_m;
    const std::size_t ticks = held.force_N.size();
    const double buzz_mN = 1e3 * test::RmsAbove(held.force_N, ticks - 2 * kSecond, ticks, kBuzzFrom_Hz);
    return {held.stiffness_N_m,
            1e3 * held.predict_s,
            cycles,
            1e3 * pressed.given_J,
            buzz_mN,
            std::min(held.least_gain, pressed.least_gain)};
  }

 private:
  // The same hand and noise without a wall.
  double Unloaded_m(const Point& p) {
    const auto key = std::make_tuple(p.damping_Ns_m, p.mass_kg, p.noise_mm);
    const auto found = unloaded_m_.find(key);
    if (found != unloaded_m_.end()) return found->second;
    const WallRun run =
        PressWall({p.mass_kg, p.damping_Ns_m}, {.noise_m = 1e-3 * p.noise_mm}, {}, WallRule::kFixed, 0, seed_);
    return unloaded_m_[key] = RmsAboutLine(run.measured_m, run.measured_m.size() - kSecond, run.measured_m.size());
  }

  std::uint64_t seed_;
  std::map<std::tuple<double, double, double>, double> unloaded_m_;
};

// K = 0.5 b_min / (T/2 + delay + coil lag), K sigma <= 30 mN, b_min = 1 Ns/m: the reference for the stiffness that the
// renderer allows.
double StartingRule_N_m(const Point& p) {
  const double lag_s = 0.5 * base::kTickPeriod_s + 1e-3 * p.delay_ms + WallLoop{}.coil_lag_s;
  const double stiffness_N_m = 0.5 / lag_s;
  return p.noise_mm > 0 ? std::min(stiffness_N_m, 30 / p.noise_mm) : stiffness_N_m;
}

nlohmann::ordered_json Row(const char* rule, const Point& p, const Outcome& outcome) {
  return {{"rule", rule},
          {"stiffness_N_m", outcome.stiffness_N_m},
          {"delay_ms", p.delay_ms},
          {"damping", p.damping_Ns_m},
          {"mass_kg", p.mass_kg},
          {"noise_mm", p.noise_mm},
          {"limit_cycle", outcome.limit_cycle},
          {"energy_mJ", outcome.energy_mJ},
          {"buzz_mN", outcome.buzz_mN}};
}

// Over all hands at one delay and noise.
struct Summary {
  int points = 0, start_good = 0, offered_bad = 0;
  double start_N_m = 0, offered_N_m = std::numeric_limits<double>::infinity(), offered_max_N_m = 0;
  double fixed_good_N_m = std::numeric_limits<double>::infinity();  // stiffest wall stable for every hand
  double worst_ratio = std::numeric_limits<double>::infinity();     // offered / start where start is good
  double predict_ms = 0, energy_mJ = 0, buzz_mN = 0;
};

class Table {
 public:
  Table(Sweep& sweep, const Grid& grid, BenchRows& rows) : sweep_(sweep), grid_(grid), rows_(rows) {}

  Summary At(double delay_ms, double noise_mm) {
    Summary sum;
    for (const double damping_Ns_m : grid_.damping_Ns_m) {
      for (const double mass_kg : grid_.mass_kg) Add({delay_ms, damping_Ns_m, mass_kg, noise_mm}, sum);
    }
    return sum;
  }

 private:
  void Add(const Point& p, Summary& sum) {
    double good_N_m = 0;
    bool all_good = true;
    for (const double stiffness_N_m : grid_.stiffness_N_m) {
      const Outcome fixed = sweep_.Run(p, WallRule::kFixed, stiffness_N_m);
      rows_.push_back(Row("fixed", p, fixed));
      all_good = all_good && fixed.Good(p.noise_mm);
      if (all_good) good_N_m = stiffness_N_m;
    }
    const Outcome start = sweep_.Run(p, WallRule::kFixed, StartingRule_N_m(p));
    const Outcome offered = sweep_.Run(p, WallRule::kBounded, kAsked_N_m);
    rows_.push_back(Row("start", p, start));
    rows_.push_back(Row("offered", p, offered));
    ++sum.points;
    sum.fixed_good_N_m = std::min(sum.fixed_good_N_m, good_N_m);
    sum.start_N_m = start.stiffness_N_m;
    sum.offered_N_m = std::min(sum.offered_N_m, offered.stiffness_N_m);
    sum.offered_max_N_m = std::max(sum.offered_max_N_m, offered.stiffness_N_m);
    sum.offered_bad += !offered.Good(p.noise_mm);
    sum.predict_ms = offered.predict_ms;
    sum.energy_mJ = std::max(sum.energy_mJ, offered.energy_mJ);
    sum.buzz_mN = std::max(sum.buzz_mN, offered.buzz_mN);
    if (!start.Good(p.noise_mm)) return;
    ++sum.start_good;
    sum.worst_ratio = std::min(sum.worst_ratio, offered.stiffness_N_m / start.stiffness_N_m);
  }

  Sweep& sweep_;
  const Grid& grid_;
  BenchRows& rows_;
};

nlohmann::ordered_json SummaryRow(double delay_ms, double noise_mm, const Summary& sum) {
  return {{"table", "offered"},
          {"delay_ms", delay_ms},
          {"noise_mm", noise_mm},
          {"hands", sum.points},
          {"start_N_m", sum.start_N_m},
          {"start_good", sum.start_good},
          {"offered_N_m", sum.offered_N_m},
          {"offered_max_N_m", sum.offered_max_N_m},
          {"offered_bad", sum.offered_bad},
          {"least_ratio", sum.start_good > 0 ? nlohmann::ordered_json(sum.worst_ratio) : nullptr},
          {"predict_ms", sum.predict_ms},
          {"energy_mJ", sum.energy_mJ},
          {"buzz_mN", sum.buzz_mN},
          {"fixed_good_N_m", sum.fixed_good_N_m}};
}

// Hands and loops outside the assumptions of stability.h: the effect of the watches.
struct Crowd {
  const char* name;
  std::vector<double> mass_kg, damping_Ns_m;
};

nlohmann::ordered_json OutsideRow(Sweep& sweep, const Crowd& crowd, double delay_ms, double late_ms, double noise_mm) {
  int hands = 0, cycles = 0, force_cut = 0, bad = 0;
  double energy_mJ = 0, buzz_mN = 0, least_N_m = std::numeric_limits<double>::infinity();
  for (const double mass_kg : crowd.mass_kg) {
    for (const double damping_Ns_m : crowd.damping_Ns_m) {
      const Outcome outcome =
          sweep.Run({delay_ms, damping_Ns_m, mass_kg, noise_mm, late_ms}, WallRule::kBounded, kAsked_N_m);
      ++hands;
      cycles += outcome.limit_cycle;
      force_cut += outcome.gain < 1;
      energy_mJ = std::max(energy_mJ, outcome.energy_mJ);
      buzz_mN = std::max(buzz_mN, outcome.buzz_mN);
      bad += !outcome.Good(kBuzzNoise_mm);
      least_N_m = std::min(least_N_m, outcome.stiffness_N_m);
    }
  }
  return {{"table", "outside"}, {"hand", crowd.name},     {"delay_ms", delay_ms},
          {"late_ms", late_ms}, {"noise_mm", noise_mm},   {"hands", hands},
          {"bad", bad},         {"limit_cycles", cycles}, {"energy_mJ", energy_mJ},
          {"buzz_mN", buzz_mN}, {"force_cut", force_cut}, {"least_offered_N_m", least_N_m}};
}

void AddOutside(bool quick, Sweep& sweep, BenchRows& rows) {
  const Crowd crowds[] = {{"firm", {0.05, 0.1, 0.2}, {1, 2, 5}}, {"light", {0.01, 0.02, 0.05}, {0.1, 0.2, 0.5}}};
  for (const Crowd& crowd : crowds) {
    for (const double noise_mm : {0.02, 0.1, 0.3}) {
      for (const double delay_ms : {1, 2, 5}) {
        for (const double late_ms : {0, 1, 2, 3, 4, 5}) {
          if (quick && (noise_mm != 0.1 || delay_ms != 2 || late_ms > 1)) continue;
          rows.push_back(OutsideRow(sweep, crowd, delay_ms, late_ms, noise_mm));
        }
      }
    }
  }
}

}  // namespace

base::Result<BenchRows> BenchStability(const BenchOptions& options) {
  const Grid grid = GridFor(options.quick);
  Sweep sweep(options.seed);
  BenchRows rows, summaries;
  Table table(sweep, grid, rows);
  for (const double noise_mm : grid.noise_mm) {
    for (const double delay_ms : grid.delay_ms) {
      summaries.push_back(SummaryRow(delay_ms, noise_mm, table.At(delay_ms, noise_mm)));
    }
  }
  rows.insert(rows.end(), summaries.begin(), summaries.end());
  AddOutside(options.quick, sweep, rows);
  const auto closed = ClosedLoop(options.seed, options.quick);
  if (!closed.ok()) return closed;
  rows.insert(rows.end(), closed->begin(), closed->end());
  return rows;
}

}  // namespace omni::bench
