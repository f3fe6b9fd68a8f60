// What the tracker assumes to be wrong when scans do not fit: one sensor, or the calibration as a whole.
// docs/theory/tracking.md, Doubt
#pragma once

#include <array>
#include <type_traits>

#include "service/base/hall_scan.h"
#include "service/tracker/kernel/measurement.h"

namespace omni::tracker {

struct DoubtOptions {
  double model_error_max = 0.01;    // relative; MakeConfig sets more for a poor calibration
  double model_error_start = 2e-3;  // before scans have been evaluated
  double cold_error_max = 0;        // limit to which a cold start raises it when nothing else fits
  double cold_sigma_max_m = 5e-3;   // of a pose that was found so
  double memory = 0.01;             // weight of the newest scan in the mean of chi2 per degree of freedom
  double memory_lately = 0.05;      // the same of a shorter mean
  // The larger of the two means: above `unsure_above` a pose's standard deviation grows by `unsure_by` times its excess
  // over 1.
  double unsure_above = 1.25, unsure_by = 2;
  // Bounds on the longer mean. Above: a sensor is blamed, or the model's error grows; below: it shrinks to the
  // calibration's own.
  double raise_above = 1.2, lower_below = 0.9;
  double raise_by = 1.25, lower_by = 0.98;  // factors per round of trials, per place
  double place_m = 3e-3;                    // distance between places: a pen at rest shows nothing of errors elsewhere
  double odd_factor = 2.2;                  // chi2 over its mean, above which the field may have jumped
  double jump_saves = 25;                   // of chi2, by assuming that the ambient field has jumped
  int trials_a_scan = 2;                    // with a sensor left out, per scan that does not fit; else one
  int rounds = 4;                           // of trials, in scans that fit badly
  double blame_saves = 15;                  // of chi2, mean over the scans, when the right sensor is left out
  int gain_places = 3;                      // of the pen, before a sensor is blamed for its gain
  int frozen_scans = 8;                     // identical readings in a row after which a sensor counts as stuck
  int check_every_scans = 16;               // whether a sensor left out agrees again
  double agrees_below = 12;                 // added to chi2 by its three readings
  int agree_min = 32, agree_max = 2048;     // checks in a row; doubled each time it proved wrong again
};

struct Doubt {
  double model_error = 0;   // relative; that of Trust applies where it is larger
  double chi2_per_dof = 1;  // mean over the last scans that fitted
  double chi2_lately = 1;   // over fewer of them
  base::Vec3 place_base_m;  // of the pen when the model's error last shrank
  int left_out = -1;        // sensor
  int agreed = 0;           // checks in a row
  int agree_needed = 0;     // 0: DoubtOptions::agree_min
  // Trials under way: in failing scans or not, their number, and the sum of what each saved.
  bool failing = false;
  int trials = 0;
  std::array<double, kSensors> saved{};
  bool none_to_blame = false;  // leaving out any one sensor did not help, since scans do not fit
};
static_assert(std::is_trivially_copyable_v<Doubt>);

// The trust with the doubt applied.
Trust TrustIn(const Doubt& doubt, Trust trust) noexcept;

// The sensor to be left out next; trials of scans that fit and of those that do not are not mixed.
int NextTrial(bool failing, Doubt& doubt) noexcept;
// The result of that trial.
void AddTrial(double saved_chi2, Doubt& doubt) noexcept;
// The sensor whose omission saves the most chi2, and how much per trial.
struct Suspect {
  int sensor = -1;
  double saved_chi2 = 0;
};
Suspect WorstOf(const Doubt& doubt) noexcept;
void EndTrials(Doubt& doubt) noexcept;

// Leaves out sensor `sensor` from now on; -1: none.
void ExcludeSensor(const DoubtOptions& options, int sensor, Doubt& doubt) noexcept;

// A magnet nearby explains what did not fit: the calibration is no worse than model_error, and a sensor left out must
// agree again for the shortest time only.
void ClearDoubt(double model_error, Doubt& doubt) noexcept;

// Factor on a pose's standard deviation while scans fit badly. `misfit`: that of a magnet nearby, relative to the
// expected one.
double SigmaFactor(const DoubtOptions& options, const Doubt& doubt, double misfit) noexcept;

// A scan fitted there with chi2 per degree of freedom `ratio`; model_error: that of the calibration.
void LearnModelError(const DoubtOptions& options, double ratio, const base::Vec3& position_base_m, double model_error,
                     Doubt& doubt) noexcept;

// Detects a sensor that repeats the same reading. docs/theory/tracking.md, Doubt
struct Repetition {
  std::array<base::Vec3, base::kSensorCount> last_T{};
  std::array<int, base::kSensorCount> times{};  // in a row that a fresh sample was the one before
};
static_assert(std::is_trivially_copyable_v<Repetition>);

// The sensor that has repeated itself `times_min` times while all others that are fresh have just changed; -1: none.
// Noise never repeats three axes for long.
int FindFrozen(const base::HallScan& scan, int times_min, Repetition& repetition) noexcept;

// After FindFrozen: all fresh sensors have repeated themselves so often. The base sends old measurements.
bool IsAllFrozen(const base::HallScan& scan, int times_min, const Repetition& repetition) noexcept;

}  // namespace omni::tracker
