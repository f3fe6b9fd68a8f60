// omni-bench align: simulated people align bases by each method; results are compared with the truth.
#include <cmath>

#include "service/tools/common/row_table.h"
#include "tests/bench/harness/bench.h"
#include "tests/support/rig/align_simulation.h"

namespace omni::bench {
namespace {

constexpr int kTrials = 100, kQuickTrials = 10;

struct AlignCase {
  const char* method;
  tools::AlignMethod use;
  bool level;
  int n;         // marks or places; 0: a sweep
  double noise;  // times the typical noise of the headset
  double wrong;  // probability of a wrong touch, or share of jumps
};

constexpr AlignCase kAlignCases[] = {
    {"touch", tools::AlignMethod::kTouch, true, 5, 1, 0},
    {"touch", tools::AlignMethod::kTouch, true, 4, 1, 0},
    {"touch", tools::AlignMethod::kTouch, true, 3, 1, 0},
    {"touch", tools::AlignMethod::kTouch, true, 5, 0.5, 0},
    {"touch", tools::AlignMethod::kTouch, true, 5, 1.5, 0},
    {"touch, 6 DoF", tools::AlignMethod::kTouch, false, 5, 1, 0},
    {"touch, one wrong", tools::AlignMethod::kTouch, true, 5, 1, 1},
    {"sweep", tools::AlignMethod::kSweep, true, 0, 1, 0},
    {"sweep", tools::AlignMethod::kSweep, true, 0, 0.5, 0},
    {"sweep", tools::AlignMethod::kSweep, true, 0, 1.5, 0},
    {"sweep, 6 DoF", tools::AlignMethod::kSweep, false, 0, 1, 0},
    {"sweep, 2 % jumps", tools::AlignMethod::kSweep, true, 0, 1, 0.02},
    {"fingertip", tools::AlignMethod::kFingertip, true, 5, 1, 0},
    {"fingertip", tools::AlignMethod::kFingertip, true, 8, 1, 0},
};

tools::AlignOptions OptionsOf(const AlignCase& what) {
  tools::AlignOptions options;
  options.method = what.use;
  options.level = what.level;
  if (what.use == tools::AlignMethod::kFingertip) options.fingertips = what.n;
  // Fewer marks: those that are furthest apart come first, the top is always among them.
  if (what.use == tools::AlignMethod::kTouch) {
    while (static_cast<int>(options.marks.size()) > what.n) options.marks.erase(options.marks.end() - 2);
  }
  return options;
}

test::AlignNoise NoiseOf(const AlignCase& what) {
  test::AlignNoise noise;
  for (double* sigma : {&noise.white_m, &noise.slow_m, &noise.white_rad, &noise.slow_rad, &noise.tremor_m}) {
    *sigma *= what.noise;
  }
  (what.use == tools::AlignMethod::kSweep ? noise.jumps : noise.wrong_touch) = what.wrong;
  return noise;
}

nlohmann::ordered_json AlignRow(const AlignCase& what, int trials, std::uint64_t seed) {
  const test::AlignNoise noise = NoiseOf(what);
  std::vector<double> error_mm, error_deg, predicted_mm, seconds;
  double squares = 0, predicted_squares = 0;
  int refused = 0, within = 0, named = 0;
  for (int i = 0; i < trials; ++i) {
    const test::AlignTrial trial =
        test::SimulateAlignment(OptionsOf(what), noise, seed + static_cast<std::uint64_t>(i));
    if (trial.refused) {
      ++refused;
      continue;
    }
    error_mm.push_back(1e3 * trial.error_m);
    error_deg.push_back(57.29577951308232 * trial.error_rad);
    predicted_mm.push_back(1e3 * trial.outcome.expected_error_m);
    seconds.push_back(trial.seconds);
    squares += trial.error_m * trial.error_m;
    predicted_squares += trial.outcome.expected_error_m * trial.outcome.expected_error_m;
    within += trial.error_m <= 2 * trial.outcome.expected_error_m;
    named += trial.wrong_touch >= 0 && trial.outcome.wrong_group == trial.wrong_touch;
  }
  const auto done = static_cast<double>(error_mm.size());
  const auto or_null = [&](double value) {
    return done > 0 ? nlohmann::ordered_json(value) : nlohmann::ordered_json();
  };
  nlohmann::ordered_json row{{"method", what.method},
                             {"n", what.n == 0 ? nlohmann::ordered_json() : nlohmann::ordered_json(what.n)},
                             {"noise_mm", 1e3 * std::hypot(noise.white_m, noise.slow_m)},
                             {"noise_deg", 57.29577951308232 * std::hypot(noise.white_rad, noise.slow_rad)},
                             {"trials", trials},
                             {"error_mm_median", or_null(tools::Quantile(error_mm, 0.5))},
                             {"error_mm_p95", or_null(tools::Quantile(error_mm, 0.95))},
                             {"error_deg", or_null(tools::Quantile(error_deg, 0.5))},
                             {"predicted_mm", or_null(tools::Quantile(predicted_mm, 0.5))},
                             {"error_over_predicted", or_null(std::sqrt(squares / predicted_squares))},
                             {"within_2_sigma", or_null(within / done)},
                             {"refused", refused},
                             {"seconds", or_null(tools::Quantile(seconds, 0.5))},
                             {"seed", seed}};
  row["wrong_named"] = what.wrong > 0 && what.use == tools::AlignMethod::kTouch ? nlohmann::ordered_json(named / done)
                                                                                : nlohmann::ordered_json();
  return row;
}

}  // namespace

base::Result<BenchRows> BenchAlign(const BenchOptions& options) {
  BenchRows rows;
  std::uint64_t seed = 1'000'000 * options.seed;
  for (const AlignCase& what : kAlignCases) {
    rows.push_back(AlignRow(what, options.quick ? kQuickTrials : kTrials, seed));
    seed += kTrials;
  }
  return rows;
}

}  // namespace omni::bench
