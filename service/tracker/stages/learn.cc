#include "service/tracker/stages/publish.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"

namespace omni::tracker {
namespace {

// For the next scan: AmbientEvidence and Mains are learnt from it too.
void LearnDrift(const Observation& observation, RoomState& room) noexcept {
  const Explanation& explanation = observation.explanation;
  if (!explanation.outcome.fit.has_sums) return;
  room.evidence =
      GatherEvidence(observation.config.drift, explanation.measurement, explanation.sums, room.drift.step_s);
  room.magnet.pose_per_moment = room.evidence.pose_per_moment;
}

// Does the sensor left out agree with the others?
void CheckLeftOut(const Observation& observation, RoomState& room) noexcept {
  const DoubtOptions& options = observation.config.doubt;
  if (room.doubt.left_out < 0 || room.scans % static_cast<std::uint32_t>(options.check_every_scans) != 0) return;
  Doubt all = room.doubt;
  all.left_out = -1;
  const bool frozen = room.repetition.times[static_cast<std::size_t>(room.doubt.left_out)] >= options.frozen_scans;
  const ScanContext context = ContextOf(observation.config, observation.received, observation.predicted, room);
  const double chi2 = observation.explanation.outcome.fit.chi2;
  const bool agrees = !frozen && Chi2Under(context, observation.predicted.filter, room.drift, all, kNoFitChi2) - chi2 <
                                     options.agrees_below;
  room.doubt.agreed = agrees ? room.doubt.agreed + 1 : 0;
  if (room.doubt.agreed >= std::max(room.doubt.agree_needed, options.agree_min)) ExcludeSensor(options, -1, room.doubt);
}

void LearnDoubt(const Observation& observation, RoomState& room) noexcept {
  const Config& config = observation.config;
  const Explanation& explanation = observation.explanation;
  if (room.doubt.failing) EndTrials(room.doubt);  // of scans that did not fit: they were few
  const double model_error = room.stray.believed ? config.doubt.model_error_start : config.trust.model_error_relative;
  LearnModelError(config.doubt, explanation.outcome.fit.chi2 / DegreesOfFreedom(explanation.measurement),
                  base::FromEigen(explanation.outcome.fit.pose.position_base_m), model_error, room.doubt);
  CheckLeftOut(observation, room);
}

bool IsDoubtful(const Config& config, const Doubt& doubt) noexcept {
  return doubt.chi2_per_dof > config.doubt.raise_above;
}

// Begins with a doubt, or when the ambient field moves as it does when a magnet approaches. young: the pose was found
// lately.
void LearnStray(const Observation& observation, bool young, RoomState& room) noexcept {
  const Config& config = observation.config;
  const StrayOptions& options = config.stray;
  StrayField& stray = room.stray;
  if (!options.enabled) return;
  if (!stray.on) {
    if (!IsDoubtful(config, room.doubt) && !IsAmbientLively(config.drift, room.drift)) return;
    StartStray(options, config.model, stray);
  }
  const Explanation& explanation = observation.explanation;
  const double repeats = RepeatsOf(config.drift, explanation.measurement, options.every_scans * base::kTickPeriod_s);
  const bool found = stray.dipole.followed() != nullptr;
  LearnStray(options, config.model, room.drift, observation.received.scan(), explanation.measurement,
             explanation.outcome.fit.pose, repeats, stray);
  if (stray.dipole.followed() != nullptr && !found) {
    ClearDoubt(config.doubt.model_error_start, room.doubt);
    if (young) stray.places_to_prove = options.places_min;
  }
  const bool gain_is_wrong = stray.dipole.wrong_gain >= 0 && stray.places >= config.doubt.gain_places;
  if (gain_is_wrong && room.doubt.left_out < 0) {
    ExcludeSensor(config.doubt, stray.dipole.wrong_gain, room.doubt);
    stray = {};
  }
}

// Is a sensor wrong, or the calibration worse than stated?
void LearnSuspect(const Observation& observation, RoomState& room) noexcept {
  const DoubtOptions& options = observation.config.doubt;
  Doubt& doubt = room.doubt;
  if (!IsDoubtful(observation.config, doubt)) return;
  TrySensor(ContextOf(observation.config, observation.received, observation.predicted, room),
            observation.predicted.filter, room.drift, false, observation.explanation.outcome.fit.chi2, doubt);
  if (doubt.trials < options.rounds * kSensors) return;
  const Suspect suspect = WorstOf(doubt);
  if (doubt.left_out < 0 && suspect.saved_chi2 > options.blame_saves)
    return ExcludeSensor(options, suspect.sensor, doubt);
  doubt.model_error =
      std::min(options.raise_by * std::max(doubt.model_error, options.model_error_start), options.model_error_max);
  EndTrials(doubt);
}

// No room is like that: a wrong pose is explained by fields that do not exist.
bool IsAbsurd(const Config& config, const RoomState& room) noexcept {
  const auto [x_T, y_T, z_T] = AmbientField_T(room.drift);
  const double size_T = std::hypot(x_T, y_T, z_T);
  const bool no_pen = IsToBeIdentified(room.magnet) && std::abs(MomentScale(room.drift) - 1) >= config.magnets.furthest;
  return no_pen || !(size_T <= config.ambient_max_T && RootMeanSquare(room.stray.mean_T) <= config.stray.max_T);
}

// What was found of sensors and calibration stays.
void Restart(State& state) noexcept {
  RoomState& room = state.room;
  room.drift = {};
  room.mains = {};
  room.stray = {};
  room.evidence = {};
  state.pose.warm = false;
  ForgetMagnet(room.magnet);
}

// A magnet nearby that leaves no trace in the field that remains has gone.
void LearnAway(const Observation& observation, bool absent, RoomState& room) noexcept {
  const Config& config = observation.config;
  const bool away = absent && !observation.received.frozen;
  if (!away || !config.away.enabled || !LearnsDrift(config)) return EndAwayWindow(room.away);
  if (WatchAway(config.away, config.model, observation.received.scan(), room.drift, room.away)) room.stray = {};
}

}  // namespace

bool Learn(const Observation& observation, State& state) noexcept {
  const Config& config = observation.config;
  RoomState& room = state.room;
  if (observation.warm()) LearnDrift(observation, room);
  if (observation.warm() && CanDoubt(config, room)) {
    LearnDoubt(observation, room);
    const bool young = room.scans - state.pose.cold_scan < static_cast<std::uint32_t>(config.stray.young_scans);
    LearnStray(observation, young, room);
    LearnSuspect(observation, room);
  }
  const bool absurd = observation.good() && IsAbsurd(config, room);
  if (absurd) Restart(state);
  const bool tracked = observation.good() && !absurd;
  LearnAway(observation, !tracked && WillBeAbsent(config, state.pose), room);
  return !absurd;
}

}  // namespace omni::tracker
