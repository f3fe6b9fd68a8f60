// What a scan may mean: rows of assumptions about room and sensors, each with the pose that fits under it.
// docs/theory/tracking.md
#pragma once

#include <limits>
#include <optional>
#include <span>

#include "service/tracker/stages/predict.h"
#include "service/tracker/stages/scan_context.h"

namespace omni::tracker {

struct Hypothesis;

// How a scan was explained, or the last attempt at it.
struct Explanation {
  const Hypothesis* by = nullptr;  // null: nothing was tried
  Outcome outcome;
  Measurement measurement;
  KernelSums sums;  // if outcome.fit.has_sums
};

// What is assumed while a scan is fitted, and adopted if the fit is accepted. Empty: as it was.
struct Proposal {
  std::optional<DriftState> drift;
  std::optional<Doubt> doubt;
  std::optional<StrayField> stray;
};

// One scan on trial.
struct Trial {
  const ScanContext& context;
  const Predicted& predicted;
  State& state;
  Explanation& best;  // so far
  Proposal proposal;
  int time = 0;  // of a row that is tried several times: from 0

  const DriftState& drift() const noexcept { return proposal.drift ? *proposal.drift : state.room.drift; }
  const Doubt& doubt() const noexcept { return proposal.doubt ? *proposal.doubt : state.room.doubt; }
  // With the proposed stray field.
  ScanContext Context() const noexcept;
};

// A row of a table. What its functions change in `trial.state` stays, whether the fit is accepted or not.
struct Hypothesis {
  const char* name;
  int times;                                     // that it is tried in turn, each time otherwise
  bool (*applies)(const Trial& trial) noexcept;  // null: always
  bool (*propose)(Trial& trial) noexcept;        // false: not in this scan; null: nothing is assumed
  Outcome (*fit)(Trial& trial, Measurement& measurement) noexcept;
  double position_variance_max_m2;  // trace of the covariance; not for hidden currents
  // A fit that is good so far; null: it is accepted. May replace both, and what is proposed.
  bool (*accepts)(Trial& trial, Measurement& measurement, Outcome& outcome) noexcept;
};

inline constexpr double kAnyVariance_m2 = std::numeric_limits<double>::infinity();

std::span<const Hypothesis> WarmHypotheses() noexcept;  // each scan of a pen that was tracked: in turn
std::span<const Hypothesis> ColdHypotheses() noexcept;  // each cold start: the next that applies
std::span<const Hypothesis> SlowHypotheses() noexcept;  // between cold starts

// Proposes that the ambient field may have jumped.
bool OpenField(Trial& trial) noexcept;

}  // namespace omni::tracker
