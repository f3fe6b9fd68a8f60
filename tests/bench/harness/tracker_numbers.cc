#include "tests/bench/harness/tracker_numbers.h"

#include <algorithm>
#include <cmath>

namespace omni::bench {
namespace {

struct Member {
  const char* name;
  std::variant<double*, int*, std::span<double>> at;
};

void Add(const std::string& of, std::initializer_list<Member> members, std::vector<TrackerNumber>& numbers) {
  for (const Member& member : members) numbers.push_back({of + "." + member.name, member.at});
}

}  // namespace

std::vector<TrackerNumber> TrackerNumbers(tracker::Config& config) {
  std::vector<TrackerNumber> numbers;
  Add("trust",
      {
          {"model_error_relative", &config.trust.model_error_relative},
          {"coil_error_relative", &config.trust.coil_error_relative},
          {"current_error_A", &config.trust.current_error_A},
          {"current_error_relative", &config.trust.current_error_relative},
          {"current_step_error", &config.trust.current_step_error},
          {"current_change_error", &config.trust.current_change_error},
          {"ambient_error_T", &config.trust.ambient_error_T},
          {"age_error_s", &config.trust.age_error_s},
          {"current_age_s", &config.trust.current_age_s},
      },
      numbers);
  Add("filter",
      {
          {"rest_speed_m_s", &config.filter.rest_speed_m_s},
          {"rest_rate_rad_s", &config.filter.rest_rate_rad_s},
          {"rest_wander_m2_s", &config.filter.rest_wander_m2_s},
          {"rest_wander_rad2_s", &config.filter.rest_wander_rad2_s},
          {"rest_wander_share", &config.filter.rest_wander_share},
          {"acceleration_m2_s3", &config.filter.acceleration_m2_s3},
          {"angular_acceleration_rad2_s3", &config.filter.angular_acceleration_rad2_s3},
          {"calm_log_min", &config.filter.calm_log_min},
          {"calm_log_max", &config.filter.calm_log_max},
          {"calm_rate", &config.filter.calm_rate},
          {"calm_memory", &config.filter.calm_memory},
          {"manoeuvre_factor", &config.filter.manoeuvre_factor},
          {"follows_1_s", std::span(&config.filter.follows_1_s[0][0], 9)},
          {"follows_pushed_1_s", std::span(&config.filter.follows_pushed_1_s[0][0], 9)},
          {"likely_at_first", std::span(config.filter.likely_at_first)},
          {"white_min", &config.filter.white_min},
          {"white_time_s", &config.filter.white_time_s},
          {"lasting_s", &config.filter.lasting_s},
      },
      numbers);
  Add("drift",
      {
          {"every_scans", &config.drift.every_scans},
          {"remanence_A", &config.drift.remanence_A},
          {"core_kept_A", &config.drift.core_kept_A},
          {"core_error", &config.drift.core_error},
          {"core_error_min_A", &config.drift.core_error_min_A},
          {"coil_core_share", &config.drift.coil_core_share},
          {"ambient_T", &config.drift.ambient_T},
          {"ambient_s", &config.drift.ambient_s},
          {"still_grows", &config.drift.still_grows},
          {"ambient_jump_T", &config.drift.ambient_jump_T},
          {"ambient_wander_min_T2_s", &config.drift.ambient_wander_min_T2_s},
          {"ambient_wander_max_T2_s", &config.drift.ambient_wander_max_T2_s},
          {"ambient_open_T", &config.drift.ambient_open_T},
          {"moment", &config.drift.moment},
          {"moment_s", &config.drift.moment_s},
          {"moment_max", &config.drift.moment_max},
          {"same_error_m", &config.drift.same_error_m},
          {"same_error_rad", &config.drift.same_error_rad},
          {"same_error_s", &config.drift.same_error_s},
      },
      numbers);
  Add("drift.still",
      {
          {"length_m", &config.drift.still.length_m},
          {"angle_rad", &config.drift.still.angle_rad},
          {"forget_s", &config.drift.still.forget_s},
          {"share", &config.drift.still.share},
          {"sigmas", &config.drift.still.sigmas},
          {"settle_s", &config.drift.still.settle_s},
          {"reference_s", &config.drift.still.reference_s},
          {"reference_max_s", &config.drift.still.reference_max_s},
      },
      numbers);
  Add("magnets",
      {
          {"warmth", &config.magnets.warmth},
          {"unknown", &config.magnets.unknown},
          {"furthest", &config.magnets.furthest},
          {"identified", &config.magnets.identified},
          {"odd_sigmas", &config.magnets.odd_sigmas},
          {"same_sigmas", &config.magnets.same_sigmas},
          {"learnt_s", &config.magnets.learnt_s},
          {"away_s", &config.magnets.away_s},
          {"away_T", &config.magnets.away_T},
          {"absent_s", &config.magnets.absent_s},
      },
      numbers);
  Add("mains",
      {
          {"candidates_Hz", std::span(config.mains.candidates_Hz)},
          {"memory_s", &config.mains.memory_s},
          {"memory_max_s", &config.mains.memory_max_s},
          {"strong_chi2", &config.mains.strong_chi2},
          {"apart_min_s", &config.mains.apart_min_s},
          {"apart_max_s", &config.mains.apart_max_s},
          {"jump_T", &config.mains.jump_T},
          {"heard_min_s", &config.mains.heard_min_s},
          {"believed_chi2", &config.mains.believed_chi2},
          {"gone_chi2", &config.mains.gone_chi2},
          {"listen_s", &config.mains.listen_s},
          {"pull", &config.mains.pull},
          {"pull_max_Hz", &config.mains.pull_max_Hz},
      },
      numbers);
  Add("doubt",
      {
          {"model_error_max", &config.doubt.model_error_max},
          {"model_error_start", &config.doubt.model_error_start},
          {"cold_error_max", &config.doubt.cold_error_max},
          {"cold_sigma_max_m", &config.doubt.cold_sigma_max_m},
          {"memory", &config.doubt.memory},
          {"memory_lately", &config.doubt.memory_lately},
          {"unsure_above", &config.doubt.unsure_above},
          {"unsure_by", &config.doubt.unsure_by},
          {"raise_above", &config.doubt.raise_above},
          {"lower_below", &config.doubt.lower_below},
          {"raise_by", &config.doubt.raise_by},
          {"lower_by", &config.doubt.lower_by},
          {"place_m", &config.doubt.place_m},
          {"odd_factor", &config.doubt.odd_factor},
          {"jump_saves", &config.doubt.jump_saves},
          {"trials_a_scan", &config.doubt.trials_a_scan},
          {"rounds", &config.doubt.rounds},
          {"blame_saves", &config.doubt.blame_saves},
          {"gain_places", &config.doubt.gain_places},
          {"frozen_scans", &config.doubt.frozen_scans},
          {"check_every_scans", &config.doubt.check_every_scans},
          {"agrees_below", &config.doubt.agrees_below},
          {"agree_min", &config.doubt.agree_min},
          {"agree_max", &config.doubt.agree_max},
      },
      numbers);
  Add("stray",
      {
          {"every_scans", &config.stray.every_scans},
          {"cycle_scans", &config.stray.cycle_scans},
          {"start", &config.stray.start},
          {"lost", &config.stray.lost},
          {"wander_start_1_s", &config.stray.wander_start_1_s},
          {"wander_min_1_s", &config.stray.wander_min_1_s},
          {"wander_max_1_s", &config.stray.wander_max_1_s},
          {"wander_grows", &config.stray.wander_grows},
          {"wander_shrinks", &config.stray.wander_shrinks},
          {"steady", &config.stray.steady},
          {"moves", &config.stray.moves},
          {"jumps", &config.stray.jumps},
          {"jumps_max", &config.stray.jumps_max},
          {"place_m", &config.stray.place_m},
          {"few_places_factor", &config.stray.few_places_factor},
          {"places_min", &config.stray.places_min},
          {"young_scans", &config.stray.young_scans},
          {"unproven_factor", &config.stray.unproven_factor},
          {"proves", &config.stray.proves},
          {"something_chi2", &config.stray.something_chi2},
          {"something_T", &config.stray.something_T},
          {"nothing_chi2", &config.stray.nothing_chi2},
          {"model_error", &config.stray.model_error},
          {"max_T", &config.stray.max_T},
          {"nothing_cycles", &config.stray.nothing_cycles},
      },
      numbers);
  Add("stray.dipole",
      {
          {"near_m", &config.stray.dipole.near_m},
          {"far_m", &config.stray.dipole.far_m},
          {"position_m", &config.stray.dipole.position_m},
          {"moment_Am2", &config.stray.dipole.moment_Am2},
          {"moment_max_Am2", &config.stray.dipole.moment_max_Am2},
          {"keep", &config.stray.dipole.keep},
          {"places_a_scan", &config.stray.dipole.places_a_scan},
          {"steps_a_scan", &config.stray.dipole.steps_a_scan},
          {"search_steps", &config.stray.dipole.search_steps},
          {"saves", &config.stray.dipole.saves},
          {"leaves", &config.stray.dipole.leaves},
          {"ends", &config.stray.dipole.ends},
          {"gain_saves", &config.stray.dipole.gain_saves},
          {"gain_leaves", &config.stray.dipole.gain_leaves},
          {"than_gain", &config.stray.dipole.than_gain},
          {"other_T", &config.stray.dipole.other_T},
          {"speed_m_s", &config.stray.dipole.speed_m_s},
          {"turn_1_s", &config.stray.dipole.turn_1_s},
          {"wander_start", &config.stray.dipole.wander_start},
          {"wander_min", &config.stray.dipole.wander_min},
          {"wander_max", &config.stray.dipole.wander_max},
          {"wander_grows", &config.stray.dipole.wander_grows},
          {"wander_shrinks", &config.stray.dipole.wander_shrinks},
          {"faster", &config.stray.dipole.faster},
          {"slower", &config.stray.dipole.slower},
      },
      numbers);
  Add("pair",
      {
          {"rounds", &config.pair.rounds},
          {"turn_steps", &config.pair.turn_steps},
          {"chi2_max", &config.pair.chi2_max},
          {"worth", &config.pair.worth},
          {"iterations_max", &config.pair.iterations_max},
      },
      numbers);
  Add("away",
      {
          {"window_s", &config.away.window_s},
          {"window_scans", &config.away.window_scans},
          {"gradient_max", &config.away.gradient_max},
          {"quiet_T", &config.away.quiet_T},
          {"steady_T", &config.away.steady_T},
          {"ambient_T", &config.away.ambient_T},
          {"zero_T", &config.away.zero_T},
          {"zero_s", &config.away.zero_s},
          {"core_A", &config.away.core_A},
          {"window_error_T", &config.away.window_error_T},
      },
      numbers);
  Add("config",
      {
          {"chi2_max", &config.chi2_max},
          {"field_min_T", &config.field_min_T},
          {"ambient_max_T", &config.ambient_max_T},
          {"axes_min", &config.axes_min},
          {"dof_min", &config.dof_min},
          {"iterations_max", &config.iterations_max},
          {"cold_iterations_max", &config.cold_iterations_max},
          {"cold_pause_scans", &config.cold_pause_scans},
          {"reach_min_m", &config.reach_min_m},
          {"reach_max_m", &config.reach_max_m},
          {"z_min_m", &config.z_min_m},
          {"coast_max_s", &config.coast_max_s},
          {"velocity_decay_s", &config.velocity_decay_s},
          {"lost_after_scans", &config.lost_after_scans},
          {"jump_max_m", &config.jump_max_m},
          {"jump_scans", &config.jump_scans},
          {"coarse_m", &config.coarse_m},
          {"tilted_cos", &config.tilted_cos},
      },
      numbers);
  return numbers;
}

double ValueOf(const TrackerNumber& number) {
  if (const auto* real = std::get_if<double*>(&number.at)) return **real;
  if (const auto* whole = std::get_if<int*>(&number.at)) return **whole;
  return *std::max_element(std::get<2>(number.at).begin(), std::get<2>(number.at).end());
}

void Scale(double factor, const TrackerNumber& number) {
  if (const auto* real = std::get_if<double*>(&number.at)) {
    **real *= factor;
  } else if (const auto* whole = std::get_if<int*>(&number.at)) {
    const double scaled = factor * **whole;
    **whole = static_cast<int>(factor < 1 ? std::floor(scaled) : std::ceil(scaled));
  } else {
    for (double& value : std::get<2>(number.at)) value *= factor;
  }
}

}  // namespace omni::bench
