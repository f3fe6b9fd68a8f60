#include "service/tracker/solve/fit_scan.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/tracker/kernel/steel.h"
#include "service/tracker/solve/cold_start.h"
#include "service/tracker/solve/other_pen.h"

namespace omni::tracker {
namespace {

using Eigen::Vector3d;

// Assumptions of cold starts: as before; the ambient field may be anything; another pen, if it may be one, and then
// both; any ambient field and one sensor left out; then all sensors with the model's error doubled time and again, as
// an uncalibrated base needs.
constexpr int kOtherPen = 2, kOtherPenAndField = 3, kFirstLeftOut = 4, kFirstDoubled = kFirstLeftOut + kSensors;
constexpr double kSurelyKnown_m2 = 25e-6;  // trace: with so much that may be wrong, a pose known worse is none
constexpr double kNoFit = 1e6;             // chi2

// Of an uncalibrated base: with less of an error than its sensors have, a fit that just passes the gate looks many
// times as certain as it is.
bool IsHonest(const Config& config, const Measurement& measurement, const Doubt& doubt, const Fit& fit) noexcept {
  return fit.chi2 <= config.doubt.raise_above * DegreesOfFreedom(measurement) ||
         doubt.model_error >= config.doubt.cold_error_max;
}

// Tries the best grid points in turn. A fit that passes the gate out of reach ends the search: the pen is elsewhere.
// The steel's response is known once there is a pose: then each is fitted again.
Outcome TryCold(const ScanContext& context, const DriftState& drift, const Doubt& doubt,
                Measurement& measurement) noexcept {
  const Config& config = context.config;
  measurement.velocity_base_m_s = {};
  measurement.axis_rate_base_1_s = {};
  Outcome outcome;
  outcome.cold = true;
  const ColdCandidates candidates = RankGrid(config.model, measurement);
  for (std::size_t c = 0; c < static_cast<std::size_t>(candidates.count); ++c) {
    const int spent = outcome.fit.iterations;
    outcome.fit = SolveCold(config, measurement, candidates.poses[c]);
    if (HasSteel(config.model) && outcome.fit.pose.position_base_m.allFinite()) {
      const int first = outcome.fit.iterations;
      const Pose expected = outcome.fit.pose;
      const SteelResponse steel = SteelResponseOf(config.model, expected, MomentScale(drift));
      measurement =
          MeasureScan({config, context.scan, context.before, context.now, &steel.field_T, context.stray, context.mains},
                      drift, doubt);
      outcome.fit = SolveCold(config, measurement, expected);
      CorrectForSteel(config.model, measurement, expected, steel, outcome.fit);
      outcome.fit.iterations += first;
    }
    outcome.fit.iterations += spent;
    const bool fits = FitsReadings(config, measurement, outcome.fit);
    outcome.explained = outcome.explained || fits;
    outcome.good = fits && IsInReach(config, outcome.fit.pose);
    // Far below or beyond the base the readings show little: only a fit well outside decides.
    if (outcome.good || (fits && outcome.fit.pose.position_base_m.norm() > config.reach_max_m)) break;
  }
  return outcome;
}

// Drift and doubts are learnt from currents that are measured.
bool CanDoubt(const Config& config, const State& state) noexcept { return LearnsDrift(config) && state.drift.valid; }

// With another ambient field than assumed, a pen far away passes for one in reach, but badly: any field explains more.
bool IsOfAnotherField(const ScanContext& context, const State& state, const Measurement& measurement,
                      const Fit& fit) noexcept {
  const Config& config = context.config;
  if (fit.chi2 <= kOddly * DegreesOfFreedom(measurement)) return false;
  DriftState open = state.drift;
  OpenAmbient(config.drift, open);
  return SolveCold(config, MeasureScan(context, open, state.doubt), fit.pose).chi2 + kFieldSaves < fit.chi2;
}

double Chi2Of(const Outcome& outcome, double otherwise) noexcept {
  return outcome.fit.converged ? outcome.fit.chi2 : otherwise;
}

// What leaving out another sensor saves of `chi2`.
void Try(const ScanContext& context, const FilterState& predicted, const DriftState& drift, bool failing, double chi2,
         Doubt& doubt) noexcept {
  Doubt trial = doubt;
  trial.left_out = NextTrial(failing, doubt);
  Measurement without = MeasureScan(context, drift, trial);
  const Outcome outcome = TryWarm(context.config, predicted, nullptr, without);
  AddTrial(std::max(0.0, chi2 - Chi2Of(outcome, chi2)), doubt);
}

// Does the sensor left out agree with the others?
void CheckLeftOut(const ScanContext& context, const FilterState& predicted, double chi2, State& state) noexcept {
  const DoubtOptions& options = context.config.doubt;
  Doubt all = state.doubt;
  all.left_out = -1;
  Measurement with = MeasureScan(context, state.drift, all);
  const bool frozen = state.repetition.times[static_cast<std::size_t>(state.doubt.left_out)] >= options.frozen_scans;
  const bool agrees =
      !frozen && Chi2Of(TryWarm(context.config, predicted, nullptr, with), kNoFit) - chi2 < options.agrees_below;
  state.doubt.agreed = agrees ? state.doubt.agreed + 1 : 0;
  if (state.doubt.agreed >= std::max(state.doubt.agree_needed, options.agree_min)) Blame(options, -1, state.doubt);
}

// Begins with a doubt, or when the ambient field moves as it does when a magnet approaches.
void WatchStray(const ScanContext& context, const Measurement& measurement, const Outcome& outcome,
                State& state) noexcept {
  const Config& config = context.config;
  const StrayOptions& options = config.stray;
  if (!options.enabled) return;
  if (!state.stray.on) {
    const bool doubtful = state.doubt.chi2_per_dof > config.doubt.raise_above;
    if (!doubtful && !IsAmbientLively(config.drift, state.drift)) return;
    StartStray(options, config.model, state.stray);
  }
  const double repeats = RepeatsOf(config.drift, measurement, options.every_scans * base::kTickPeriod_s);
  const bool found = state.stray.dipole.found;
  LearnStray(options, config.model, state.drift, context.scan, measurement, outcome.fit.pose, repeats, state.stray);
  if (state.stray.dipole.found && !found) {
    Clear(config.doubt.model_error_start, state.doubt);
    const bool young = state.scans - state.cold_scan < static_cast<std::uint32_t>(options.young_scans);
    if (young) state.stray.places_to_prove = options.places_min;
  }
  const bool gain_is_wrong = state.stray.dipole.wrong_gain >= 0 && state.stray.places >= config.doubt.gain_places;
  if (gain_is_wrong && state.doubt.left_out < 0) {
    Blame(config.doubt, state.stray.dipole.wrong_gain, state.doubt);
    state.stray = {};
  }
}

}  // namespace

Outcome TryWarm(const Config& config, const FilterState& predicted, KernelSums* sums,
                Measurement& measurement) noexcept {
  const Vector3d u = base::ToEigen(predicted.axis_base);
  const Vector3d u_rate = base::ToEigen(predicted.angular_velocity_base_rad_s).cross(u);
  const base::Vec3& v = predicted.velocity_base_m_s;
  measurement.velocity_base_m_s = {v.x, v.y, v.z};
  measurement.axis_rate_base_1_s = {u_rate.x(), u_rate.y(), u_rate.z()};
  Outcome outcome;
  outcome.fit = SolvePose(config.model, measurement, {base::ToEigen(predicted.position_base_m), u},
                          {.precision = PrecisionOf(config), .iterations_max = config.iterations_max, .sums = sums});
  outcome.explained = FitsReadings(config, measurement, outcome.fit);
  outcome.good = outcome.explained && IsInReach(config, outcome.fit.pose);
  return outcome;
}

void BlameFrozen(const Config& config, const base::HallScan& scan, State& state) noexcept {
  const int frozen = FindFrozen(scan, config.doubt.frozen_scans, state.repetition);
  if (frozen >= 0 && state.doubt.left_out < 0 && CanDoubt(config, state)) Blame(config.doubt, frozen, state.doubt);
}

bool TryJump(const ScanContext& context, const FilterState& predicted, State& state, Measurement& measurement,
             Outcome& outcome) noexcept {
  const Config& config = context.config;
  const DoubtOptions& options = config.doubt;
  const double expected = DegreesOfFreedom(measurement) * std::max(1.0, state.doubt.chi2_per_dof);
  if (!CanDoubt(config, state) || !(outcome.fit.chi2 > options.odd_factor * expected)) return false;
  DriftState open = state.drift;
  OpenAmbient(config.drift, open);
  Measurement free = MeasureScan(context, open, state.doubt);
  const Outcome other = TryWarm(config, predicted, nullptr, free);
  if (!other.good || other.fit.chi2 + options.jump_saves > outcome.fit.chi2) return false;
  state.drift = open;
  measurement = free;
  outcome = other;
  return true;
}

bool TryOtherHypotheses(const ScanContext& context, const FilterState& predicted, State& state,
                        Measurement& measurement, Outcome& outcome) noexcept {
  const Config& config = context.config;
  if (!CanDoubt(config, state)) return false;
  const auto holds = [&](const DriftState& drift, const Doubt& doubt) {
    measurement = MeasureScan(context, drift, doubt);
    outcome = TryWarm(config, predicted, nullptr, measurement);
    if (!outcome.good) return false;
    state.drift = drift;
    state.doubt = doubt;
    return true;
  };
  DriftState open = state.drift;
  OpenAmbient(config.drift, open);
  if (holds(open, state.doubt)) return true;
  if (state.stray.believed && state.doubt.none_to_blame) {
    LoosenStray(config.stray, config.model, state.stray);
    if (holds(open, state.doubt)) return true;
  }
  const double chi2 = Chi2Of(outcome, kNoFit);
  for (int k = 0; k < config.doubt.trials_a_scan; ++k) Try(context, predicted, open, true, chi2, state.doubt);
  if (state.doubt.trials < kSensors) return false;
  Doubt blaming = state.doubt;
  Blame(config.doubt, WorstOf(state.doubt).sensor, blaming);
  EndTrials(state.doubt);
  if (holds(open, blaming)) return true;
  state.doubt.none_to_blame = true;
  if (!state.stray.on || state.stray.believed || state.stray.nothing_cycles > 0) return false;
  // Something was moving already; a sudden change is no magnet being laid down.
  LoosenStray(config.stray, config.model, state.stray);
  state.stray.believed = true;
  if (holds(open, state.doubt)) return true;
  state.stray.believed = false;
  return false;
}

Outcome TryColdHypothesis(const ScanContext& context, State& state, Measurement& measurement) noexcept {
  const Config& config = context.config;
  const bool one_pen = state.magnet.identified || state.doubt.left_out >= 0;  // a wrong sensor passes for another pen
  if (one_pen && state.belief == kOtherPen) state.belief = kFirstLeftOut;
  if (state.magnet.foreign_s > 0 && state.belief > 0) state.belief = state.belief == 1 ? kOtherPen : 0;
  const int belief = CanDoubt(config, state) ? state.belief++ : 0;
  if (belief == 0) {
    Outcome outcome = TryCold(context, state.drift, state.doubt, measurement);
    if (CanDoubt(config, state)) {
      outcome.good = outcome.good && PositionVariance(outcome.fit) <= kKnown_m2 &&
                     !IsOfAnotherField(context, state, measurement, outcome.fit);
      MeetMagnet(context, state.drift, state.doubt, state.drift, measurement, outcome, state.magnet);
    }
    if (outcome.good) state.belief = 0;
    return outcome;
  }
  DriftState drift = state.drift;
  if (belief != kOtherPen) OpenAmbient(config.drift, drift);
  Doubt doubt = state.doubt;
  if (belief == kOtherPen || belief == kOtherPenAndField) {
    Outcome outcome = SeekOtherPen(context, doubt, drift, measurement, state.magnet);
    if (!outcome.good) return outcome;
    IdentifyMagnet(config.magnets, drift, state.magnet);
    state.drift = drift;
    state.belief = 0;
    return outcome;
  }
  const bool doubled = belief >= kFirstDoubled;
  if (doubled) {
    const double error = std::max(doubt.model_error, config.trust.model_error_relative);
    doubt.model_error = std::min(std::ldexp(error, belief - kFirstDoubled + 1), config.doubt.cold_error_max);
  }
  if (belief + 1 >= kFirstDoubled && doubt.model_error >= config.doubt.cold_error_max) state.belief = 0;
  const bool left_out = belief >= kFirstLeftOut && belief < kFirstDoubled;
  Blame(config.doubt, left_out ? belief - kFirstLeftOut : -1, doubt);
  measurement = MeasureScan(context, drift, doubt);
  Outcome outcome = TryCold(context, drift, doubt, measurement);
  const double variance_m2 = PositionVariance(outcome.fit);
  outcome.good = outcome.good && (doubled ? std::sqrt(variance_m2) <= config.doubt.cold_sigma_max_m &&
                                                IsHonest(config, measurement, doubt, outcome.fit)
                                          : variance_m2 <= kSurelyKnown_m2);
  MeetMagnet(context, state.drift, doubt, drift, measurement, outcome, state.magnet);
  if (!outcome.good) return outcome;
  state.drift = drift;
  state.doubt = doubt;
  state.belief = 0;
  return outcome;
}

Outcome TryPair(const ScanContext& context, State& state, Measurement& measurement) noexcept {
  const Config& config = context.config;
  Outcome outcome;
  if (!config.pair.enabled || !config.stray.enabled || state.magnet.foreign_s > 0 || !CanDoubt(config, state))
    return outcome;
  DriftState drift = state.drift;
  OpenAmbient(config.drift, drift);
  Doubt doubt;
  doubt.model_error = std::max(config.doubt.model_error_start, config.stray.model_error);
  if (state.pair.step == PairStart::Step::kNone) {
    ScanContext bare = context;
    bare.stray = nullptr;
    BeginPair(config.model, MeasureScan(bare, drift, doubt), state.pair);
    return outcome;
  }
  if (!SeekPair(config.pair, config.stray.dipole, config.model, drift, state.pair)) return outcome;
  StrayField stray;
  if (!StartFromDipole(config.stray, config.model, state.pair.magnet, stray)) return outcome;
  ScanContext beside = context;
  beside.stray = &stray;
  measurement = MeasureScan(beside, drift, doubt);
  outcome = TryCold(beside, drift, doubt, measurement);
  outcome.good = outcome.good && PositionVariance(outcome.fit) <= kSurelyKnown_m2;
  outcome.good = outcome.good && !IsOneMagnet(context, state, outcome.fit);
  if (!outcome.good) return outcome;
  ConfirmMagnet(drift, state.magnet);
  state.drift = drift;
  state.doubt = doubt;
  state.stray = stray;
  state.belief = 0;
  return outcome;
}

void DoubtOn(const ScanContext& context, const FilterState& predicted, const Measurement& measurement,
             const Outcome& outcome, State& state) noexcept {
  const Config& config = context.config;
  if (!CanDoubt(config, state)) return;
  Doubt& doubt = state.doubt;
  if (doubt.failing) EndTrials(doubt);  // of scans that did not fit: they were few
  const double chi2 = outcome.fit.chi2;
  const double model_error = state.stray.believed ? config.doubt.model_error_start : config.trust.model_error_relative;
  LearnModelError(config.doubt, chi2 / DegreesOfFreedom(measurement), base::FromEigen(outcome.fit.pose.position_base_m),
                  model_error, doubt);
  if (doubt.left_out >= 0) {
    if (state.scans % static_cast<std::uint32_t>(config.doubt.check_every_scans) == 0) {
      CheckLeftOut(context, predicted, chi2, state);
    }
  }
  WatchStray(context, measurement, outcome, state);
  if (!(doubt.chi2_per_dof > config.doubt.raise_above)) return;
  Try(context, predicted, state.drift, false, chi2, doubt);
  if (doubt.trials < config.doubt.rounds * kSensors) return;
  const Suspect suspect = WorstOf(doubt);
  if (doubt.left_out < 0 && suspect.saved_chi2 > config.doubt.blame_saves)
    return Blame(config.doubt, suspect.sensor, doubt);
  doubt.model_error = std::min(config.doubt.raise_by * std::max(doubt.model_error, config.doubt.model_error_start),
                               config.doubt.model_error_max);
  EndTrials(doubt);
}

}  // namespace omni::tracker
