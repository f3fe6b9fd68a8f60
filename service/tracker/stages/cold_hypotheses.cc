#include <algorithm>
#include <cmath>

#include "service/tracker/kernel/measurement.h"
#include "service/tracker/kernel/steel.h"
#include "service/tracker/solve/solver.h"
#include "service/tracker/stages/hypothesis.h"

namespace omni::tracker {
namespace {

constexpr double kSurelyKnown_m2 = 25e-6;  // trace: with so much that may be wrong, a pose known worse is none
constexpr int kDoublings = 16;             // at most
// The search for another pen's moment: places of the grid to start from; steps, their greatest size, and the last one's
// in standard deviations.
constexpr int kMomentStarts = 3, kMomentSteps = 8;
constexpr double kMomentStepMax = 0.25, kMomentSettled = 0.3;
constexpr double kForeignSigmas = 2, kForeign_s = 2;  // beyond what a pen may have: then it is none, for so long
constexpr double kMomentMin = 0.1, kMomentMax = 3;    // where it may lead, to see that a magnet is no pen's
constexpr double kUnsure = 0.045;   // of the moment, where the last pen fits and a scan says too little
constexpr double kOddlyOpen = 2.5;  // chi2 per degree of freedom of another pen in any ambient field, at most
constexpr double kSimpler = 4;      // of chi2: so much less does not make any other field likelier than another pen

// The fit once more, with the sums that say what the scan knows of the moment.
MomentEvidence MomentAt(const ScanContext& context, const DriftState& drift, Measurement& measurement, Fit& fit,
                        Magnet& magnet) noexcept {
  const Config& config = context.config;
  AddAmbientColumns(measurement);
  KernelSums sums;
  const Fit again =
      SolvePose(config.model, measurement, fit.pose,
                {.precision = PrecisionOf(config), .iterations_max = config.iterations_max, .sums = &sums});
  if (!again.has_sums || !again.pose.position_base_m.allFinite()) return {};
  const int spent = fit.iterations;
  fit = again;
  fit.iterations += spent;
  const DriftEvidence evidence = GatherEvidence(config.drift, measurement, sums, 0);
  magnet.pose_per_moment = evidence.pose_per_moment;
  return OfMoment(evidence, drift);
}

// Pose and moment of a pen of which nothing is known, from `start`: Gauss-Newton steps of the moment, each at the best
// pose. False: they lead nowhere.   docs/theory/tracking.md (10.2)
bool FollowMoment(const ScanContext& context, const Doubt& doubt, const Pose& start, DriftState& drift,
                  Measurement& measurement, Fit& fit, Magnet& magnet) noexcept {
  const Config& config = context.config;
  const double known = 1 / (config.magnets.unknown * config.magnets.unknown);
  Pose pose = start;
  for (int k = 0; k < kMomentSteps; ++k) {
    std::optional<SteelResponse> steel;
    ScanContext beside = context;
    if (k > 0 && HasSteel(config.model)) {
      steel = SteelResponseOf(config.model, pose, MomentScale(drift));
      beside.local = &steel->field_T;
    }
    measurement = MeasureScan(beside, drift, doubt);
    const Pose expected = pose;
    fit = SolveCold(config, measurement, pose);
    if (!fit.pose.position_base_m.allFinite()) return false;
    const MomentEvidence said = MomentAt(context, drift, measurement, fit, magnet);
    if (!said.valid) return false;
    if (steel) CorrectForSteel(config.model, measurement, expected, *steel, fit);
    pose = fit.pose;
    const double relative = MomentScale(drift) - 1, information = said.information + known;
    const double step = (said.gradient - known * relative) / information;
    SetMoment(relative + std::clamp(step, -kMomentStepMax, kMomentStepMax), 1 / information, drift);
    if (!(MomentScale(drift) >= kMomentMin && MomentScale(drift) <= kMomentMax)) return false;
    if (k > 0 && std::abs(step) * std::sqrt(information) < kMomentSettled) {
      return FitsReadings(config, measurement, fit);
    }
  }
  return false;
}

// Is that a pen? A magnet that fits with a moment that no pen has is none for a while.
bool SeekMoment(const ScanContext& context, const Doubt& doubt, const Pose& start, DriftState& drift,
                Measurement& measurement, Outcome& outcome, Magnet& magnet) noexcept {
  const Config& config = context.config;
  outcome = {};
  outcome.cold = true;
  if (!FollowMoment(context, doubt, start, drift, measurement, outcome.fit, magnet)) return false;
  const double away = std::abs(MomentScale(drift) - 1) - config.magnets.furthest;
  const bool well = outcome.fit.chi2 <= kOddly * DegreesOfFreedom(measurement);
  if (well && away > kForeignSigmas * std::sqrt(MomentVariance(drift))) magnet.foreign_s = kForeign_s;
  outcome.explained = away < 0;
  outcome.good = outcome.explained && IsInReach(config, outcome.fit.pose) && PositionVariance(outcome.fit) <= kKnown_m2;
  if (!outcome.good || well) return outcome.good;
  if (doubt.left_out >= 0) return outcome.good = false;
  if (IsAmbientLively(config.drift, drift)) {
    outcome.good = outcome.fit.chi2 <= kOddlyOpen * DegreesOfFreedom(measurement);
    return outcome.good;
  }
  // As for the calibrated pen: any ambient field must not explain much more.
  DriftState open = drift;
  OpenAmbient(config.drift, open);
  Measurement other;
  Fit fit;
  Magnet unused = magnet;
  const bool follows = FollowMoment(context, doubt, outcome.fit.pose, open, other, fit, unused);
  outcome.good = !(follows && fit.chi2 + kFieldSaves < outcome.fit.chi2);
  return outcome.good;
}

// Pose and moment without a hint, in the ambient field of `drift`, of which `measurement` is. If it is good, `drift`
// holds the moment, and `measurement` is of it.
Outcome SeekOtherPen(const ScanContext& context, const Doubt& doubt, DriftState& drift, Measurement& measurement,
                     Magnet& magnet) noexcept {
  const DriftState before = drift;
  Outcome outcome;
  const ColdCandidates candidates = RankGrid(context.config.model, measurement, kMomentStarts);
  for (std::size_t c = 0; c < static_cast<std::size_t>(candidates.count) && !outcome.good; ++c) {
    drift = before;
    SeekMoment(context, doubt, candidates.poses[c], drift, measurement, outcome, magnet);
  }
  return outcome;
}

// A scan that fits the magnet that was there last, which may have been exchanged. If it needs another ambient field,
// would another pen do, in the field as it was (`before`)? Does it contradict that moment? Then both are searched, in
// that field, else in any. If it says too little, the moment is an unknown of the scans to come.
void MeetMagnet(const ScanContext& context, const DriftState& before, const Doubt& doubt, DriftState& drift,
                Measurement& measurement, Outcome& outcome, Magnet& magnet) noexcept {
  const MagnetOptions& options = context.config.magnets;
  if (magnet.identified || !outcome.good) return;
  const Pose start = outcome.fit.pose;
  Outcome other;
  DriftState trial = before;
  Measurement of_other;
  const bool any_field = IsAmbientLively(context.config.drift, drift);
  if (any_field && SeekMoment(context, doubt, start, trial, of_other, other, magnet) &&
      other.fit.chi2 <= outcome.fit.chi2 + kSimpler) {
    drift = trial;
    measurement = of_other;
    outcome = other;
    return IdentifyMagnet(options, drift, magnet);
  }
  Fit fit = outcome.fit;
  const MomentEvidence said = MomentAt(context, drift, measurement, fit, magnet);
  if (!said.valid) return SetMoment(MomentScale(drift) - 1, kUnsure * kUnsure, drift);
  const double variance = 1 / said.information, shift = said.gradient * variance;
  const double expected = variance + options.warmth * options.warmth;
  if (shift * shift <= options.odd_sigmas * options.odd_sigmas * expected) {
    const double known = 1 / (options.unknown * options.unknown);
    const double posterior = 1 / (said.information + known);
    if (posterior <= options.identified * options.identified) return ConfirmMagnet(drift, magnet);
    outcome.good = outcome.fit.chi2 <= kOddly * DegreesOfFreedom(measurement);  // else it is no pen, or another
    SetMoment(MomentScale(drift) - 1, kUnsure * kUnsure, drift);
    return;
  }
  trial = before;
  if (!SeekMoment(context, doubt, start, trial, measurement, outcome, magnet)) {
    trial = drift;
    OpenAmbient(context.config.drift, trial);
    if (!SeekMoment(context, doubt, start, trial, measurement, outcome, magnet)) return;
  }
  drift = trial;
  IdentifyMagnet(options, drift, magnet);
}

// Would one magnet do, whatever its moment, where a pen and a magnet have been found?
bool IsOneMagnet(const ScanContext& context, const RoomState& room, const Fit& found) noexcept {
  if (room.magnet.identified) return false;
  ScanContext bare = context;
  bare.stray = nullptr;
  DriftState drift = room.drift;
  OpenAmbient(context.config.drift, drift);
  Measurement measurement;
  Fit fit;
  Magnet unused = room.magnet;
  return FollowMoment(bare, room.doubt, found.pose, drift, measurement, fit, unused);
}

// A magnet that is no pen's is there: then only another one in its place is expected.
bool IsPens(const Trial& trial) noexcept {
  return CanDoubt(trial.fixed.config, trial.state.room) && !(trial.state.room.magnet.foreign_s > 0);
}

// A wrong sensor passes for another pen.
bool MayBeOther(const Trial& trial) noexcept {
  const RoomState& room = trial.state.room;
  return CanDoubt(trial.fixed.config, room) && !room.magnet.identified && room.doubt.left_out < 0;
}

bool MayBeOtherInAnyField(const Trial& trial) noexcept { return IsPens(trial) && MayBeOther(trial); }

double ModelErrorOf(const Trial& trial, int doublings) noexcept {
  const Config& config = trial.fixed.config;
  if (doublings == 0) return trial.state.room.doubt.model_error;
  const double error = std::max(trial.state.room.doubt.model_error, config.trust.model_error_relative);
  return std::min(std::ldexp(error, doublings), config.doubt.cold_error_max);
}

bool MayBePoor(const Trial& trial) noexcept {
  return IsPens(trial) && ModelErrorOf(trial, trial.time) < trial.fixed.config.doubt.cold_error_max;
}

bool KeepField(Trial& trial) noexcept {
  trial.proposal.drift = trial.state.room.drift;
  return true;
}

bool LeaveOut(int sensor, Trial& trial) noexcept {
  OpenField(trial);
  trial.proposal.doubt = trial.state.room.doubt;
  ExcludeSensor(trial.fixed.config.doubt, sensor, *trial.proposal.doubt);
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
  return FitCold(trial.Assumed(), trial.drift(), trial.doubt(), measurement);
}

Outcome WithMoment(Trial& trial, Measurement& measurement) noexcept {
  return SeekOtherPen(trial.fixed, trial.doubt(), *trial.proposal.drift, measurement, trial.state.room.magnet);
}

// Is it the pen that was there last?
bool IsPenMet(Trial& trial, Measurement& measurement, Outcome& outcome) noexcept {
  if (!trial.proposal.drift) KeepField(trial);
  MeetMagnet(trial.fixed, trial.state.room.drift, trial.doubt(), *trial.proposal.drift, measurement, outcome,
             trial.state.room.magnet);
  return outcome.good;
}

// With another ambient field than assumed, a pen far away passes for one in reach, but badly: any field explains more.
bool IsOfThisField(Trial& trial, Measurement& measurement, Outcome& outcome) noexcept {
  const ScanContext& context = trial.fixed;
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
  IdentifyMagnet(trial.fixed.config.magnets, *trial.proposal.drift, trial.state.room.magnet);
  return true;
}

// Of an uncalibrated base: with less of an error than its sensors have, a fit that just passes the gate looks many
// times as certain as it is.
bool IsHonest(Trial& trial, Measurement& measurement, Outcome& outcome) noexcept {
  const DoubtOptions& options = trial.fixed.config.doubt;
  if (!(std::sqrt(PositionVariance(outcome.fit)) <= options.cold_sigma_max_m)) return false;
  const bool honest = outcome.fit.chi2 <= options.raise_above * DegreesOfFreedom(measurement) ||
                      trial.doubt().model_error >= options.cold_error_max;
  return honest && IsPenMet(trial, measurement, outcome);
}

constexpr Hypothesis kCold[] = {
    {"as before", 1, nullptr, nullptr, FromGrid, kKnown_m2, IsOfThisField},
    {"any field", 1, IsPens, ClearSensors, FromGrid, kSurelyKnown_m2, IsPenMet},
    {"another pen", 1, MayBeOther, KeepField, WithMoment, kKnown_m2, IdentifyOther},
    {"another pen, any field", 1, MayBeOtherInAnyField, OpenField, WithMoment, kKnown_m2, IdentifyOther},
    {"one sensor wrong, any field", kSensors, IsPens, LeaveOutNext, FromGrid, kSurelyKnown_m2, IsPenMet},
    {"poor calibration, any field", kDoublings, MayBePoor, DoubleError, FromGrid, kAnyVariance_m2, IsHonest},
};

// One more step of the search for a magnet that was there from the start.
bool SeekMagnet(Trial& trial) noexcept {
  const Config& config = trial.fixed.config;
  PairStart& pair = trial.state.search.pair;
  OpenField(trial);
  trial.proposal.doubt.emplace().model_error = std::max(config.doubt.model_error_start, config.stray.model_error);
  if (pair.step == PairStart::Step::kNone) {
    ScanContext bare = trial.fixed;
    bare.stray = nullptr;
    BeginPair(config.model, MeasureScan(bare, trial.drift(), trial.doubt()), pair);
    return false;
  }
  return SeekPair(config.pair, config.stray.dipole, config.model, trial.drift(), pair) &&
         StartFromDipole(config.stray, config.model, pair.magnet, trial.proposal.stray.emplace());
}

bool MayBePair(const Trial& trial) noexcept {
  const Config& config = trial.fixed.config;
  return config.pair.enabled && config.stray.enabled && IsPens(trial);
}

bool AreTwo(Trial& trial, Measurement&, Outcome& outcome) noexcept {
  if (IsOneMagnet(trial.fixed, trial.state.room, outcome.fit)) return false;
  ConfirmMagnet(*trial.proposal.drift, trial.state.room.magnet);
  return true;
}

constexpr Hypothesis kSlow[] = {{"magnet from the start", 1, MayBePair, SeekMagnet, FromGrid, kSurelyKnown_m2, AreTwo}};

static_assert(AreComplete(kCold) && AreComplete(kSlow));
static_assert(kCold[0].applies == nullptr && kCold[0].propose == nullptr, "one that can always be tried");

}  // namespace

std::span<const Hypothesis> ColdHypotheses() noexcept { return kCold; }
std::span<const Hypothesis> SlowHypotheses() noexcept { return kSlow; }

}  // namespace omni::tracker
