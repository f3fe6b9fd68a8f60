// What the tracker holds to be wrong when scans do not fit: one sensor, or the calibration as a whole.
// docs/theory/tracking.md, Doubt
#pragma once

#include <array>
#include <type_traits>

#include "service/tracker/kernel/measurement.h"

namespace omni::tracker {

struct DoubtOptions {
  double model_error_max = 0.01;    // relative; MakeConfig sets more for a poor calibration
  double model_error_start = 2e-3;  // until scans have told
  double cold_error_max = 0;        // up to which a cold start raises it when nothing else holds
  double memory = 0.01;             // share of the newest scan in the mean of chi2 per degree of freedom
  double memory_lately = 0.05;      // the same of a shorter mean
  // Of the larger of the two: above, poses are known worse; its excess is as so many standard deviations.
  double unsure_above = 1.25, unsure_by = 2;
  // Of that mean. Above: a sensor is blamed, or the model's error grows; below: it shrinks to what the calibration
  // says.
  double raise_above = 1.2, lower_below = 0.9;
  double raise_by = 1.25, lower_by = 0.98;  // factors a round of trials, a place
  double place_m = 3e-3;                    // so far apart: a pen at rest cannot tell what is wrong elsewhere
  double odd_factor = 2.2;                  // a scan whose chi2 is larger than its mean by that: has the field jumped?
  double jump_saves = 25;                   // of chi2, what an ambient field that has jumped explains
  int trials_a_scan = 2;                    // with a sensor left out, of a scan that does not fit; else one
  int rounds = 4;                           // of trials, of scans that fit badly
  double blame_saves = 15;                  // of chi2, mean over the scans: what leaving out the right sensor must save
  int gain_places = 3;                      // of the pen, before a sensor is blamed for its gain
  int frozen_scans = 8;                     // a sensor that repeats itself so often measures nothing
  int check_every_scans = 16;               // of a sensor left out: does it agree again?
  double agrees_below = 12;                 // of chi2, what its three readings then add
  int agree_min = 32, agree_max = 2048;     // checks in a row; twice as many after each time that it was wrong again
};

struct Doubt {
  double model_error = 0;   // relative; the trust's holds where it is larger
  double chi2_per_dof = 1;  // mean over the last scans that fitted
  double chi2_lately = 1;   // over fewer of them
  base::Vec3 place_base_m;  // of the pen when the model's error last shrank
  int left_out = -1;        // sensor
  int agreed = 0;           // checks in a row
  int agree_needed = 0;     // 0: DoubtOptions::agree_min
  // Trials under way: of which scans, how many, and the sum of what each saved.
  bool failing = false;
  int trials = 0;
  std::array<double, kSensors> saved{};
};
static_assert(std::is_trivially_copyable_v<Doubt>);

// The trust as it is under a doubt.
Trust TrustIn(const Doubt& doubt, Trust trust) noexcept;

// The sensor to be left out next; trials of scans that fit and of others do not add up.
int NextTrial(bool failing, Doubt& doubt) noexcept;
// What came of it.
void AddTrial(double saved_chi2, Doubt& doubt) noexcept;
// The sensor whose absence saves most, and how much a trial.
struct Suspect {
  int sensor = -1;
  double saved_chi2 = 0;
};
Suspect WorstOf(const Doubt& doubt) noexcept;
void EndTrials(Doubt& doubt) noexcept;

// Sensor `sensor` is left out from now on; -1: all count again.
void Blame(const DoubtOptions& options, int sensor, Doubt& doubt) noexcept;

// A magnet nearby explains what did not fit: no sensor is wrong, and the calibration is no worse than model_error.
void Clear(double model_error, Doubt& doubt) noexcept;

// How much more than the fit says is not known of a pose while scans fit badly, or what is believed of a magnet nearby
// does, by `misfit` times what it should: factor of its standard deviation.
double Unsureness(const DoubtOptions& options, const Doubt& doubt, double misfit) noexcept;

// A scan fitted there with chi2 per degree of freedom `ratio`; model_error: that of the calibration.
void LearnModelError(const DoubtOptions& options, double ratio, const base::Vec3& position_base_m, double model_error,
                     Doubt& doubt) noexcept;

}  // namespace omni::tracker
