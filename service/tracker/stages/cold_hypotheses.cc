#include <algorithm>
#include <cmath>

#include "service/tracker/solve/other_pen.h"
#include "service/tracker/stages/hypothesis.h"

namespace omni::tracker {
namespace {

constexpr double kSurelyKnown_m2 = 25e-6;  // trace: with so much that may be wrong, a pose known worse is none
constexpr int kDoublings = 16;             // at most

// A magnet that is no pen's is there: then only another one in its place is expected.
bool IsPens(const Trial& trial) noexcept {
  return CanDoubt(trial.context.config, trial.state.room) && !(trial.state.room.magnet.foreign_s > 0);
}

// A wrong sensor passes for another pen.
bool MayBeOther(const Trial& trial) noexcept {
  const RoomState& room = trial.state.room;
  return CanDoubt(trial.context.config, room) && !room.magnet.identified && room.doubt.left_out < 0;
}

bool MayBeOtherInAnyField(const Trial& trial) noexcept { return IsPens(trial) && MayBeOther(trial); }

double ModelErrorOf(const Trial& trial, int doublings) noexcept {
  const Config& config = trial.context.config;
  if (doublings == 0) return trial.state.room.doubt.model_error;
  const double error = std::max(trial.state.room.doubt.model_error, config.trust.model_error_relative);
  return std::min(std::ldexp(error, doublings), config.doubt.cold_error_max);
}

bool MayBePoor(const Trial& trial) noexcept {
  return IsPens(trial) && ModelErrorOf(trial, trial.time) < trial.context.config.doubt.cold_error_max;
}

bool KeepField(Trial& trial) noexcept {
  trial.proposal.drift = trial.state.room.drift;
  return true;
}

bool LeaveOut(int sensor, Trial& trial) noexcept {
  OpenField(trial);
  trial.proposal.doubt = trial.state.room.doubt;
  Blame(trial.context.config.doubt, sensor, *trial.proposal.doubt);
  return true;
}

bool ClearSensors(Trial& trial) noexcept { return LeaveOut(-1, trial); }
bool LeaveOutNext(Trial& trial) noexcept { return LeaveOut(trial.time, trial); }

bool DoubleError(Trial& trial) noexcept {
  LeaveOut(-1, trial);
  trial.proposal.doubt->model_error = ModelErrorOf(trial, trial.time + 1);
  return true;
}

Outcome FromGrid(Trial& trial, Measurement& measurement) noexcept {
  return FitCold(trial.Context(), trial.drift(), trial.doubt(), measurement);
}

Outcome WithMoment(Trial& trial, Measurement& measurement) noexcept {
  return SeekOtherPen(trial.context, trial.doubt(), *trial.proposal.drift, measurement, trial.state.room.magnet);
}

// Is it the pen that was there last?
bool IsPenMet(Trial& trial, Measurement& measurement, Outcome& outcome) noexcept {
  if (!trial.proposal.drift) KeepField(trial);
  MeetMagnet(trial.context, trial.state.room.drift, trial.doubt(), *trial.proposal.drift, measurement, outcome,
             trial.state.room.magnet);
  return outcome.good;
}

// With another ambient field than assumed, a pen far away passes for one in reach, but badly: any field explains more.
bool IsOfThisField(Trial& trial, Measurement& measurement, Outcome& outcome) noexcept {
  const ScanContext& context = trial.context;
  const RoomState& room = trial.state.room;
  if (!CanDoubt(context.config, room)) return true;
  if (outcome.fit.chi2 > kOddly * DegreesOfFreedom(measurement)) {
    DriftState open = room.drift;
    OpenAmbient(context.config.drift, open);
    const Fit other = SolveCold(context.config, MeasureScan(context, open, room.doubt), outcome.fit.pose);
    if (other.chi2 + kFieldSaves < outcome.fit.chi2) return false;
  }
  return IsPenMet(trial, measurement, outcome);
}

bool IdentifyOther(Trial& trial, Measurement&, Outcome&) noexcept {
  IdentifyMagnet(trial.context.config.magnets, *trial.proposal.drift, trial.state.room.magnet);
  return true;
}

// Of an uncalibrated base: with less of an error than its sensors have, a fit that just passes the gate looks many
// times as certain as it is.
bool IsHonest(Trial& trial, Measurement& measurement, Outcome& outcome) noexcept {
  const DoubtOptions& options = trial.context.config.doubt;
  if (!(std::sqrt(PositionVariance(outcome.fit)) <= options.cold_sigma_max_m)) return false;
  const bool honest = outcome.fit.chi2 <= options.raise_above * DegreesOfFreedom(measurement) ||
                      trial.doubt().model_error >= options.cold_error_max;
  return honest && IsPenMet(trial, measurement, outcome);
}

constexpr Hypothesis kCold[] = {
    {"as before", 1, AppliesAlways, nullptr, FromGrid, kKnown_m2, IsOfThisField},
    {"any field", 1, IsPens, ClearSensors, FromGrid, kSurelyKnown_m2, IsPenMet},
    {"another pen", 1, MayBeOther, KeepField, WithMoment, kKnown_m2, IdentifyOther},
    {"another pen, any field", 1, MayBeOtherInAnyField, OpenField, WithMoment, kKnown_m2, IdentifyOther},
    {"one sensor wrong, any field", kSensors, IsPens, LeaveOutNext, FromGrid, kSurelyKnown_m2, IsPenMet},
    {"poor calibration, any field", kDoublings, MayBePoor, DoubleError, FromGrid, kAnyVariance_m2, IsHonest},
};

// One more step of the search for a magnet that was there from the start.
bool SeekMagnet(Trial& trial) noexcept {
  const Config& config = trial.context.config;
  PairStart& pair = trial.state.search.pair;
  OpenField(trial);
  trial.proposal.doubt.emplace().model_error = std::max(config.doubt.model_error_start, config.stray.model_error);
  if (pair.step == PairStart::Step::kNone) {
    ScanContext bare = trial.context;
    bare.stray = nullptr;
    BeginPair(config.model, MeasureScan(bare, trial.drift(), trial.doubt()), pair);
    return false;
  }
  return SeekPair(config.pair, config.stray.dipole, config.model, trial.drift(), pair) &&
         StartFromDipole(config.stray, config.model, pair.magnet, trial.proposal.stray.emplace());
}

bool MayBePair(const Trial& trial) noexcept {
  const Config& config = trial.context.config;
  return config.pair.enabled && config.stray.enabled && IsPens(trial);
}

bool AreTwo(Trial& trial, Measurement&, Outcome& outcome) noexcept {
  if (IsOneMagnet(trial.context, trial.state.room, outcome.fit)) return false;
  ConfirmMagnet(*trial.proposal.drift, trial.state.room.magnet);
  return true;
}

constexpr Hypothesis kSlow[] = {{"magnet from the start", 1, MayBePair, SeekMagnet, FromGrid, kSurelyKnown_m2, AreTwo}};

}  // namespace

std::span<const Hypothesis> ColdHypotheses() noexcept { return kCold; }
std::span<const Hypothesis> SlowHypotheses() noexcept { return kSlow; }

}  // namespace omni::tracker
