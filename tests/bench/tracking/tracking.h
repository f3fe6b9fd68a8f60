// The parts of `omni-bench tracking`. Truth is the twin; errors are in the base frame, unaligned.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/base/truth_parameters.h"
#include "service/tracker/tracker.h"
#include "tests/bench/harness/bench.h"
#include "tests/bench/harness/errors.h"
#include "tests/bench/harness/room_conditions.h"

namespace omni::bench {

struct TrackingConditions {
  // default: the product, tracker::Update as omnid calls it, with its own error model. All others are studies with the
  // static solver: noise-only assumes only the sensors' noise, a rung is the same with a simpler model.
  std::string model = "default";
  std::string noise = "UHP";          // UHP | LP | none
  double actuation_A = 0;             // greatest current of each coil
  std::string currents = "measured";  // measured | hidden
  std::string calibrated = "exact";   // none | self | exact
  bool moving = false;
  bool room = false;
};

// Means over the poses; 1 = the estimate reaches the bound.
struct Efficiency {
  double position = 0;     // |e|^2 / trace(CRLB)
  double orientation = 0;  // the same of the axis
  double nees = 0;         // e^T C^-1 e / 5, C as the tracker reports it
};

nlohmann::ordered_json TrackingRow(const TrackingConditions& conditions, const ErrorSet& errors, std::size_t n,
                                   const std::vector<std::uint64_t>& seeds,
                                   const std::optional<Efficiency>& efficiency = {});

// As tracked by the product after the whole of `omni calibrate` on site.
base::Result<tracker::Config> SelfCalibrated(std::uint64_t seed, const base::TruthParameters& truth);

struct TrackingPlan {
  std::vector<std::uint64_t> seeds;
  std::size_t share = 1;  // --quick: the work divided by this
};

// Scans without noise at any tilt, contact included: error of the model itself. The product, and one row per rung.
base::Result<BenchRows> ModelErrors(const TrackingPlan& plan);
// Against the Cramer-Rao bound; side table: the bound by radius.
base::Result<BenchRows> Efficiencies(const TrackingPlan& plan);
// Static scans under current: measured, the product; hidden, a study.
base::Result<BenchRows> UnderCurrent(const TrackingPlan& plan);
// The paper's protocol: a waved pen and sawtooth currents, self-calibrated, exact, uncalibrated, and in a room.
base::Result<BenchRows> PaperProtocol(const TrackingPlan& plan);
// Side table: creep of the pose of a pen that lies still.
base::Result<BenchRows> Rest(const TrackingPlan& plan);
// Side table: cost of unknown currents.
base::Result<BenchRows> Levels(const TrackingPlan& plan);

}  // namespace omni::bench
