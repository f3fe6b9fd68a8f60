#include <algorithm>
#include <iterator>

#include "service/tracker/stages/hypothesis.h"

namespace omni::tracker {
namespace {

bool IsUnexplained(const Trial& trial) noexcept {
  return !trial.best.outcome.good && CanDoubt(trial.fixed.config, trial.state.room);
}

Outcome FromPrediction(Trial& trial, Measurement& measurement) noexcept {
  const bool first = trial.best.by == nullptr;
  return FitWarm(trial.fixed.config, trial.predicted.filter, first && trial.predicted.wide ? &trial.best.sums : nullptr,
                 measurement);
}

// The scan fits nowhere near, or much worse than the ones before.
bool FitsOddly(const Trial& trial) noexcept {
  const Config& config = trial.fixed.config;
  const RoomState& room = trial.state.room;
  const double expected = DegreesOfFreedom(trial.best.measurement) * std::max(1.0, room.doubt.chi2_per_dof);
  const Outcome& outcome = trial.best.outcome;
  return CanDoubt(config, room) && (!outcome.good || outcome.fit.chi2 > config.doubt.odd_factor * expected);
}

bool SavesEnough(Trial& trial, Measurement&, Outcome& outcome) noexcept {
  const Outcome& before = trial.best.outcome;
  return !before.good || outcome.fit.chi2 + trial.fixed.config.doubt.jump_saves <= before.fit.chi2;
}

bool MayHaveLoosened(const Trial& trial) noexcept {
  return IsUnexplained(trial) && trial.state.room.stray.believed && trial.state.room.doubt.none_to_blame;
}

bool LoosenMagnet(Trial& trial) noexcept {
  LoosenStray(trial.fixed.config.stray, trial.fixed.config.model, trial.state.room.stray);
  return OpenField(trial);
}

// After a round of trials, some in each scan: the sensor whose omission saves the most.
bool BlameWorst(Trial& trial) noexcept {
  const DoubtOptions& options = trial.fixed.config.doubt;
  Doubt& doubt = trial.state.room.doubt;
  OpenField(trial);
  const double chi2 = Chi2Of(trial.best.outcome, kNoFitChi2);
  for (int k = 0; k < options.trials_a_scan; ++k) {
    TrySensor(trial.fixed, trial.predicted.filter, trial.drift(), true, chi2, doubt);
  }
  if (doubt.trials < kSensors) return false;
  trial.proposal.doubt = doubt;
  ExcludeSensor(options, WorstOf(doubt).sensor, *trial.proposal.doubt);
  EndTrials(doubt);
  doubt.none_to_blame = true;
  return true;
}

// Something was moving already when a round of trials ended without a result: a sudden change is no magnet being laid
// down.
bool MayHaveArrived(const Trial& trial) noexcept {
  const RoomState& room = trial.state.room;
  return IsUnexplained(trial) && room.doubt.none_to_blame && room.doubt.trials == 0 && room.stray.on &&
         !room.stray.believed && room.stray.nothing_cycles == 0;
}

bool BelieveMagnet(Trial& trial) noexcept {
  LoosenMagnet(trial);
  trial.proposal.stray = trial.state.room.stray;
  trial.proposal.stray->believed = true;
  return true;
}

// The order counts: one that explains the scan is adopted before the next is tried, which then applies to a scan that
// fits; what is tried before a sensor is blamed is what leaving it out is compared with.
constexpr Hypothesis kRows[] = {
    {"as predicted", 1, nullptr, nullptr, FromPrediction, kAnyVariance_m2, nullptr},
    {"field jumped", 1, FitsOddly, OpenField, FromPrediction, kAnyVariance_m2, SavesEnough},
    {"magnet loosened", 1, MayHaveLoosened, LoosenMagnet, FromPrediction, kAnyVariance_m2, nullptr},
    {"one sensor wrong", 1, IsUnexplained, BlameWorst, FromPrediction, kAnyVariance_m2, nullptr},
    {"magnet arrived", 1, MayHaveArrived, BelieveMagnet, FromPrediction, kAnyVariance_m2, nullptr},
};

static_assert(AreComplete(kRows) &&
              std::all_of(std::begin(kRows), std::end(kRows), [](const Hypothesis& row) { return row.times == 1; }));

}  // namespace

bool OpenField(Trial& trial) noexcept {
  trial.proposal.drift = trial.state.room.drift;
  OpenAmbient(trial.fixed.config.drift, *trial.proposal.drift);
  return true;
}

std::span<const Hypothesis> WarmHypotheses() noexcept { return kRows; }

}  // namespace omni::tracker
