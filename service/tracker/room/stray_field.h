// The non-uniform field of objects near the base, such as another pen, a phone or a laptop: one offset for every
// reading, estimated from scans whose pose is eliminated. One magnet, once it is found, is followed as a dipole.
// docs/theory/tracking.md (13.1) - (13.6)
#pragma once

#include <array>
#include <type_traits>

#include "service/tracker/room/stray_dipole.h"
#include "service/tracker/room/stray_scan.h"

namespace omni::tracker {

// K: StrayPrior::covariance_T2.
struct StrayOptions {
  bool enabled = true;
  int every_scans = 4;   // of which one is gathered ...
  int cycle_scans = 16;  // ... until the estimate is renewed
  // Shares of K: unknown when a doubt begins; added when a scan fits no pose, until all of K is unknown.
  double start = 1e-4, lost = 0.02;
  double wander_start_1_s = 1e-3, wander_min_1_s = 1e-6, wander_max_1_s = 4;  // change of K per second, learnt
  double wander_grows = 2, wander_shrinks = 0.8;                              // per cycle
  // Innovation relative to the expected one, which allows for model errors too: the field is steady; it moves; it has
  // moved further than was thought possible.
  double steady = 0.3, moves = 0.5, jumps = 1, jumps_max = 10;
  // Until the pen has visited so many places so far apart, a pose's covariance is multiplied: at one place the field is
  // known from K only, and K is an average over magnets.
  double place_m = 0.02, few_places_factor = 9;
  int places_min = 8;
  // The same of a magnet that was found together with the pen, or so soon after it; a place counts where it leaves no
  // more than that, per degree of freedom.
  int young_scans = 2000;
  double unproven_factor = 9, proves = 1.6;
  // The mean's own chi2 and size (rms over the readings) above which it is accepted: less is calibration error. Below,
  // nothing may be there; after so many such cycles in a row, nothing is.
  double something_chi2 = 40, something_T = 8e-7, nothing_chi2 = 25;
  double model_error = 1.5e-3;  // relative, while one is searched for: the core responds to that magnet too
  double max_T = 6e-5;          // of that size; more is a wrong pose: a pen at 200 mm makes 2e-5 to 4e-5
  int nothing_cycles = 128;
  DipoleOptions dipole;
};

struct StrayField {
  bool on = false;          // it is being learnt
  bool believed = false;    // `mean_T` is subtracted from every scan
  bool inverted = false;    // `inverse_1_T2` is of this cycle
  int scan = 0;             // of the cycle
  int nothing_cycles = 0;   // in a row
  int places = 0;           // of the pen since no pose was found, or a dipole was lost
  int places_to_prove = 0;  // that the pen must still visit, for a magnet found together with the pen
  base::Vec3 place_base_m;
  double wander_1_s = 0;  // of K
  double widened = 0;     // of K, since the start
  double chi2 = 0;        // of the mean
  ReadingLanes mean_T{};  // in the sensors' axes
  ReadingMatrix covariance_T2{};
  ReadingLanes variance_T2{};  // its diagonal
  // Of a pose, due to the uncertainty of the mean; of the axis: rad^2, each way.
  std::array<double, 9> position_covariance_m2{};
  double axis_variance = 0;
  // Of the cycle: evidence about the mean; sums over its scans of the new share, of the number with the same model
  // error, and of that error's share of their variance; the covariance's inverse; a pose's response, dp = -gain x.
  StrayEvidence cycle;
  double share = 0, repeats = 0, systematic = 0;
  ReadingMatrix inverse_1_T2{};
  std::array<ReadingLanes, kParameters> gain{};
  StrayDipole dipole;
};
static_assert(std::is_trivially_copyable_v<StrayField>);

// Nothing is found yet.
void StartStray(const StrayOptions& options, const Model& model, StrayField& stray) noexcept;

// A magnet has been found together with the pen. False: none is like that.
bool StartFromDipole(const StrayOptions& options, const Model& model, const StrayDipole& dipole,
                     StrayField& stray) noexcept;

// A scan fits no pose: the field may have changed.
void LoosenStray(const StrayOptions& options, const Model& model, StrayField& stray) noexcept;

// After each scan that fitted at `pose`: adds its evidence, or updates the estimate, or finds that nothing is there.
// repeats: scans like this one that have the model's error in common.
void LearnStray(const StrayOptions& options, const Model& model, const DriftState& drift,
                const base::HallScan& readings, const Measurement& measurement, const Pose& pose, double repeats,
                StrayField& stray) noexcept;

// Adds the uncertainty of the stray field to a fit.
void AddStrayCovariance(const StrayOptions& options, const StrayField& stray, Fit& fit) noexcept;

}  // namespace omni::tracker
