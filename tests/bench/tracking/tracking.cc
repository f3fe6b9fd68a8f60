// omni-bench tracking: error of the tracker against the truth, and against the bound of any method.
#include "tests/bench/tracking/tracking.h"

#include <iostream>

#include "service/loop/realtime.h"

namespace omni::bench {
namespace {

constexpr std::size_t kQuick = 100;

}  // namespace

nlohmann::ordered_json TrackingRow(const TrackingConditions& conditions, const ErrorSet& errors, std::size_t n,
                                   const std::vector<std::uint64_t>& seeds,
                                   const std::optional<Efficiency>& efficiency) {
  nlohmann::ordered_json row{{"model", conditions.model},
                             {"noise", conditions.noise},
                             {"actuation_A", conditions.actuation_A},
                             {"currents", conditions.currents},
                             {"calibrated", conditions.calibrated},
                             {"moving", conditions.moving},
                             {"room", conditions.room},
                             {"n", n},
                             {"mean_mm", tools::Mean(errors.position_mm)},
                             {"median_mm", tools::Quantile(errors.position_mm, 0.5)},
                             {"p95_mm", tools::Quantile(errors.position_mm, 0.95)},
                             {"max_mm", tools::Quantile(errors.position_mm, 1)},
                             {"orientation_mean_deg", tools::Mean(errors.axis_deg)},
                             {"orientation_max_deg", tools::Quantile(errors.axis_deg, 1)},
                             {"failures", errors.failures},
                             {"seeds", SeedText(seeds)}};
  if (efficiency) {
    row["mse_over_crlb"] = efficiency->position;
    row["orientation_mse_over_crlb"] = efficiency->orientation;
    row["nees_per_dof"] = efficiency->nees;
  }
  return row;
}

base::Result<BenchRows> BenchTracking(const BenchOptions& options) {
  loop::FlushDenormals();
  const TrackingPlan plan{ThreeSeeds(options.seed), options.quick ? kQuick : 1};
  struct Part {
    const char* about;
    base::Result<BenchRows> (*run)(const TrackingPlan&);
  };
  // The first row has the most keys: a table prints those.
  constexpr Part kParts[] = {{"efficiency", Efficiencies},
                             {"model error", ModelErrors},
                             {"static scans under current", UnderCurrent},
                             {"the paper's protocol", PaperProtocol},
                             {"rest", Rest},
                             {"levels", Levels}};
  BenchRows rows;
  for (const Part& part : kParts) {
    std::cerr << part.about << " ...\n";
    auto more = part.run(plan);
    if (!more.ok()) return more;
    rows.insert(rows.end(), more->begin(), more->end());
  }
  return rows;
}

}  // namespace omni::bench
