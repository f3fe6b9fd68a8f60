// What a scan may mean: rows of assumptions about room and sensors, each with the pose that fits under it.
// docs/theory/tracking.md
#pragma once

#include <limits>
#include <optional>
#include <span>
#include <string_view>

#include "service/tracker/stages/predict.h"
#include "service/tracker/stages/scan_context.h"

namespace omni::tracker {

struct Hypothesis;

// How a scan was explained, or the last attempt at it. Constructed, as Trial is: aggregates would be filled with zeros
// first, 27 KB in every scan.
struct Explanation {
  explicit Explanation(const ScanContext& context, const RoomState& room) noexcept
      : measurement(MeasureScan(context, room.drift, room.doubt)) {}

  const Hypothesis* by = nullptr;  // null: nothing was tried
  Outcome outcome;
  Measurement measurement;
  KernelSums sums{};  // if outcome.fit.has_sums: of the scan as predicted, since drift is learnt from no other
};

// What is assumed while a scan is fitted, and adopted if the fit is accepted. Empty: as it was.
struct Proposal {
  std::optional<DriftState> drift;
  std::optional<Doubt> doubt;
  std::optional<StrayField> stray;

  void Reset() noexcept {  // an assignment would copy all of it
    drift.reset();
    doubt.reset();
    stray.reset();
  }
};

// One scan on trial.
struct Trial {
  Trial(const ScanContext& scan, const Predicted& from, State& now, Explanation& so_far) noexcept
      : fixed(scan), predicted(from), state(now), best(so_far) {}

  const ScanContext& fixed;  // whatever is assumed
  const Predicted& predicted;
  State& state;
  Explanation& best;  // so far
  Proposal proposal;
  int time = 0;  // of a row that is tried several times: from 0

  const DriftState& drift() const noexcept { return proposal.drift ? *proposal.drift : state.room.drift; }
  const Doubt& doubt() const noexcept { return proposal.doubt ? *proposal.doubt : state.room.doubt; }
  ScanContext Assumed() const noexcept;  // with the proposed stray field
};

// A row of a table. What its functions change in `trial.state` stays, whether the fit is accepted or not; so does
// outcome.explained, which says that some pose fits, this one or another. A row costs a measurement and a fit, 2 to 4
// us, and is tried in a tick: what takes longer is divided over scans. One that has a source of its own, beside drift
// and stray field, subtracts it from the measurement, or Learn would take it for the stray field.
// Each is needed by a test: tests/tracker/hypotheses.cc.
struct Hypothesis {
  const char* name;                              // also that of ToolState::hypothesis
  int times;                                     // cold rows: that it is tried in turn, each time otherwise; else 1
  bool (*applies)(const Trial& trial) noexcept;  // null: always
  bool (*propose)(Trial& trial) noexcept;        // false: not in this scan; null: nothing is assumed
  Outcome (*fit)(Trial& trial, Measurement& measurement) noexcept;
  double position_variance_max_m2;  // trace of the covariance; not for hidden currents
  // A fit that is good so far; null: it is accepted. May replace both, and what is proposed.
  bool (*accepts)(Trial& trial, Measurement& measurement, Outcome& outcome) noexcept;
};

// Each row has a name of its own, a fit and a limit.
constexpr bool AreComplete(std::span<const Hypothesis> rows) noexcept {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].name == nullptr || rows[i].fit == nullptr || !(rows[i].position_variance_max_m2 > 0)) return false;
    for (std::size_t j = 0; j < i; ++j) {
      if (std::string_view(rows[i].name) == rows[j].name) return false;
    }
  }
  return true;
}

inline constexpr double kAnyVariance_m2 = std::numeric_limits<double>::infinity();

std::span<const Hypothesis> WarmHypotheses() noexcept;  // each scan of a pen that was tracked: in turn
std::span<const Hypothesis> ColdHypotheses() noexcept;  // each cold start: the next that applies
std::span<const Hypothesis> SlowHypotheses() noexcept;  // between cold starts

// Proposes that the ambient field may have jumped.
bool OpenField(Trial& trial) noexcept;

// Third stage: the pose that explains a scan, and under which assumption.
// outcome.good: found, and `state` holds what was assumed. The fit is of the steel's response at its pose.
Explanation Explain(const Config& config, const Received& received, const Predicted& predicted, State& state) noexcept;

// Of the received scan, with nothing assumed.
ScanContext ContextOf(const Config& config, const Received& received, const Predicted& predicted,
                      const RoomState& room) noexcept;

}  // namespace omni::tracker
