#include "service/tracker/room/doubt.h"

#include <algorithm>
#include <cmath>

#include "service/base/vec.h"

namespace omni::tracker {
namespace {

constexpr double kRatioMax = 10;  // of one scan, in the shorter mean

}  // namespace

Trust TrustIn(const Doubt& doubt, Trust trust) noexcept {
  const double known = trust.model_error_relative;
  trust.model_error_relative = std::max(known, doubt.model_error);
  if (known > 0) trust.coil_error_relative *= trust.model_error_relative / known;
  if (doubt.left_out >= 0) trust.sensors_out |= 1u << doubt.left_out;
  return trust;
}

int NextTrial(bool failing, Doubt& doubt) noexcept {
  if (doubt.failing != failing) EndTrials(doubt);
  doubt.failing = failing;
  return doubt.trials % kSensors;
}

void AddTrial(double saved_chi2, Doubt& doubt) noexcept {
  doubt.saved[static_cast<std::size_t>(doubt.trials % kSensors)] += saved_chi2;
  ++doubt.trials;
}

Suspect WorstOf(const Doubt& doubt) noexcept {
  const auto worst = std::max_element(doubt.saved.begin(), doubt.saved.end());
  return {static_cast<int>(worst - doubt.saved.begin()), *worst * kSensors / std::max(doubt.trials, kSensors)};
}

void EndTrials(Doubt& doubt) noexcept {
  doubt.trials = 0;
  doubt.saved = {};
  doubt.none_to_blame = false;
}

void ExcludeSensor(const DoubtOptions& options, int sensor, Doubt& doubt) noexcept {
  const int needed = doubt.agree_needed == 0 ? options.agree_min : doubt.agree_needed;
  if (sensor < 0 && doubt.left_out >= 0) doubt.agree_needed = std::min(2 * needed, options.agree_max);
  doubt.left_out = sensor;
  doubt.agreed = 0;
  doubt.chi2_per_dof = 1;
  EndTrials(doubt);
}

void ClearDoubt(double model_error, Doubt& doubt) noexcept {
  doubt.model_error = std::min(doubt.model_error, model_error);
  doubt.agreed = doubt.agree_needed = 0;
  doubt.chi2_per_dof = doubt.chi2_lately = 1;
  EndTrials(doubt);
}

double SigmaFactor(const DoubtOptions& options, const Doubt& doubt, double misfit) noexcept {
  const double chi2 = std::max({doubt.chi2_per_dof, doubt.chi2_lately, misfit});
  return chi2 > options.unsure_above ? 1 + options.unsure_by * (chi2 - 1) : 1;
}

void LearnModelError(const DoubtOptions& options, double ratio, const base::Vec3& position_base_m, double model_error,
                     Doubt& doubt) noexcept {
  doubt.chi2_lately += options.memory_lately * (std::min(ratio, kRatioMax) - doubt.chi2_lately);
  doubt.chi2_per_dof += options.memory * (ratio - doubt.chi2_per_dof);
  if (doubt.chi2_per_dof >= options.lower_below || doubt.model_error <= model_error) return;
  if (base::Distance(position_base_m, doubt.place_base_m) < options.place_m) return;
  doubt.place_base_m = position_base_m;
  doubt.model_error *= options.lower_by;
  doubt.model_error = std::max(doubt.model_error, model_error);
}

int FindFrozen(const base::HallScan& scan, int times_min, Repetition& repetition) noexcept {
  int frozen = -1, repeating = 0, changed = 0;
  for (std::size_t i = 0; i < repetition.times.size(); ++i) {
    if (((scan.fresh_mask >> i) & 1u) == 0) continue;
    int& times = repetition.times[i];
    times = scan.field_sensor_T[i] == repetition.last_T[i] ? std::min(times + 1, times_min) : 0;
    repetition.last_T[i] = scan.field_sensor_T[i];
    repeating += times > 0 ? 1 : 0;
    changed += times == 0 ? 1 : 0;
    if (times >= times_min) frozen = static_cast<int>(i);
  }
  return repeating == 1 && changed > 0 ? frozen : -1;
}

bool IsAllFrozen(const base::HallScan& scan, int times_min, const Repetition& repetition) noexcept {
  bool some = false;
  for (std::size_t i = 0; i < repetition.times.size(); ++i) {
    if (((scan.fresh_mask >> i) & 1u) == 0) continue;
    if (repetition.times[i] < times_min) return false;
    some = true;
  }
  return some;
}

}  // namespace omni::tracker
