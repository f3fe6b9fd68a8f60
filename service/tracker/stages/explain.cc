#include "service/tracker/stages/hypothesis.h"

#include "service/base/eigen.h"
#include "service/tracker/kernel/measurement.h"

namespace omni::tracker {
namespace {

void Adopt(const Proposal& proposal, RoomState& room) noexcept {
  if (proposal.drift) room.drift = *proposal.drift;
  if (proposal.doubt) room.doubt = *proposal.doubt;
  if (proposal.stray) room.stray = *proposal.stray;
}

// A fit that is good so far.
bool Holds(const Hypothesis& row, Trial& trial, Measurement& measurement, Outcome& outcome) noexcept {
  const bool known = PositionVariance(outcome.fit) <= row.position_variance_max_m2;
  if (CanDoubt(trial.fixed.config, trial.state.room) && !known) return false;
  return row.accepts == nullptr || row.accepts(trial, measurement, outcome);
}

// Measures and fits under the row's assumption; adopts both if the fit is accepted. The first row that assumes nothing
// takes the measurement that is there. False: the row is not tried in this scan.
bool Try(const Hypothesis& row, Trial& trial) noexcept {
  if (row.applies != nullptr && !row.applies(trial)) return false;
  trial.proposal.Reset();
  if (row.propose != nullptr && !row.propose(trial)) return false;
  Explanation& best = trial.best;
  const bool first = best.by == nullptr && row.propose == nullptr;
  std::optional<Measurement> other;
  if (!first) other = MeasureScan(trial.Assumed(), trial.drift(), trial.doubt());
  Measurement& measurement = first ? best.measurement : *other;
  Outcome outcome = row.fit(trial, measurement);
  outcome.good = outcome.good && Holds(row, trial, measurement, outcome);
  if (!outcome.good && best.outcome.good) return true;
  outcome.explained = outcome.explained || best.outcome.explained;
  if (!first) best.measurement = *other;
  best.outcome = outcome;
  best.by = &row;
  if (outcome.good) Adopt(trial.proposal, trial.state.room);
  return true;
}

void TryAll(std::span<const Hypothesis> rows, Trial& trial) noexcept {
  for (const Hypothesis& row : rows) Try(row, trial);
}

// The next time of the next row that applies; the first again after the last, or after one that explains the scan.
void TryNext(std::span<const Hypothesis> rows, Trial& trial) noexcept {
  SearchState& search = trial.state.search;
  for (bool tried = false; !tried;) {
    const Hypothesis& row = rows[static_cast<std::size_t>(search.cold_row)];
    trial.time = search.cold_time;
    tried = Try(row, trial);
    const bool again = tried && ++search.cold_time < row.times;
    if (again) continue;
    search.cold_time = 0;
    search.cold_row = (search.cold_row + 1) % static_cast<int>(rows.size());
  }
}

void Seek(Trial& trial) noexcept {
  const Config& config = trial.fixed.config;
  const bool warm = trial.state.pose.warm;
  SearchState& search = trial.state.search;
  const Outcome& outcome = trial.best.outcome;
  bool tried = warm;
  if (warm) TryAll(WarmHypotheses(), trial);
  if (!outcome.good && --search.cold_pause < 0) {
    TryNext(ColdHypotheses(), trial);
    search.cold_pause = outcome.good ? 0 : config.cold_pause_scans;
    tried = true;
  } else if (!outcome.good && !warm && !search.explained) {
    TryAll(SlowHypotheses(), trial);
    tried = outcome.good;
  }
  if (tried) search.explained = outcome.explained;
  if (outcome.good && outcome.cold) search.cold_row = search.cold_time = 0;
}

// No hand carries a pen there within a scan: more likely this scan is wrong and happens to fit. A pen that stays there
// is accepted.
bool IsEarlyJump(const Config& config, const PoseState& pose, const FilterState& predicted,
                 const Outcome& outcome) noexcept {
  const Eigen::Vector3d jump = outcome.fit.pose.position_base_m - base::ToEigen(predicted.position_base_m);
  return pose.bad_scans < config.jump_scans && !(jump.norm() <= config.jump_max_m);
}

}  // namespace

ScanContext Trial::Assumed() const noexcept {
  ScanContext with = fixed;
  if (proposal.stray) with.stray = &*proposal.stray;
  return with;
}

ScanContext ContextOf(const Config& config, const Received& received, const Predicted& predicted,
                      const RoomState& room) noexcept {
  return {config,
          received.scan(),
          room.currents_before,
          room.currents,
          predicted.steel ? &predicted.steel->field_T : nullptr,
          &room.stray,
          predicted.mains};
}

Explanation Explain(const Config& config, const Received& received, const Predicted& predicted, State& state) noexcept {
  const ScanContext context = ContextOf(config, received, predicted, state.room);
  Explanation best(context, state.room);
  if (predicted.wide) AddAmbientColumns(best.measurement);
  if (received.frozen || !HasMagnet(config, best.measurement)) return best;
  Trial trial(context, predicted, state, best);
  Seek(trial);
  Outcome& outcome = best.outcome;
  if (predicted.continues && IsEarlyJump(config, state.pose, predicted.filter, outcome)) outcome.good = false;
  if (outcome.good && !outcome.cold && predicted.steel) {
    CorrectForSteel(config.model, best.measurement, PoseOf(predicted.filter), *predicted.steel, outcome.fit);
  }
  return best;
}

}  // namespace omni::tracker
