// One magnet nearby, another pen say, as a dipole: its position and moment, found from the scans' evidence of offsets
// in their readings, then followed from scan to scan. docs/theory/tracking.md (13.4), (13.6)
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>
#include <variant>

#include "service/tracker/room/stray_scan.h"

namespace omni::tracker {

inline constexpr std::size_t kDipoleParameters = 6;  // position from the core's centre, m; moment, A m^2; frame B

struct DipoleOptions {
  bool enabled = true;
  double near_m = 0.12, far_m = 1.2;        // from the core's centre
  double position_m = 0.5, moment_Am2 = 5;  // prior, rms each way
  double moment_max_Am2 = 15;               // three pens: a start with more is at the wrong place
  double keep = 0.9;                        // of the evidence, per cycle
  int places_a_scan = 8, steps_a_scan = 2, search_steps = 32;
  // Misfit: what a dipole must save, and may leave per degree of freedom. While it is followed: what ends it.
  double saves = 30, leaves = 2, ends = 2.5;
  // The same for one sensor with a wrong gain; a dipole, which has five numbers more, must save so much more than that.
  double gain_saves = 30, gain_leaves = 1.5, than_gain = 10;
  double other_T = 3e-7;  // part of its field that is not a dipole's
  // While it is followed. Its speed is learnt, as a share of these: above `faster` it moves, below `slower` it rests.
  double speed_m_s = 1, turn_1_s = 5;
  double wander_start = 1e-2, wander_min = 1e-10, wander_max = 4, wander_grows = 4, wander_shrinks = 0.9;
  double faster = 1.5, slower = 1;
};

using DipoleNumbers = std::array<double, kDipoleParameters>;

// The search tries places in turn, then takes steps from the best; what they find is followed.
struct DipolePlaces {
  int next = 0, best = 0;
  double best_saved = 0;  // of the misfit
  DipoleNumbers best_parameters{};
};
struct DipoleSteps {
  int place = 0;  // that they began from
  int taken = 0;
  double damping = 0;
};
struct FollowedDipole {
  double wander = 0, scans = 0;       // speed squared, as a share; scans since it moved
  double innovation = 1, misfit = 1;  // means: over what is expected; per degree of freedom
};

using DipoleStage = std::variant<DipolePlaces, DipoleSteps, FollowedDipole>;

struct StrayDipole {
  DipoleStage stage;
  DipoleNumbers parameters{};  // of the steps, or of what they found
  std::array<double, kDipoleParameters * kDipoleParameters> covariance{};
  StrayEvidence lately;                    // until it is found
  std::array<std::uint64_t, 2> nowhere{};  // places whose steps led nowhere
  int wrong_gain = -1;                     // the sensor whose gain explains the recent evidence better

  const FollowedDipole* followed() const noexcept { return std::get_if<FollowedDipole>(&stage); }  // null: not found
};
static_assert(std::is_trivially_copyable_v<StrayDipole>);

// Every few scans until it is found: tries some more places, or takes some steps from the best.
void SearchDipole(const DipoleOptions& options, const Model& model, StrayDipole& dipole) noexcept;

// Starts a search in the evidence of one scan: everywhere, or `steps` steps on from where the last one ended.
void StartSearch(const DipoleOptions& options, const StrayEvidence& said, int steps, StrayDipole& dipole) noexcept;
bool IsSearching(const StrayDipole& dipole) noexcept;  // after SearchDipole: it has not finished

// Accepts the result of such a search as the magnet. False: the evidence does not locate it.
bool FindDipole(const DipoleOptions& options, const Model& model, StrayDipole& dipole) noexcept;

// Each cycle until a dipole, or a sensor with a wrong gain, is found. repeats: scans that have the model's error in
// common, systematic: its share of their variance.
void JudgeDipole(const DipoleOptions& options, const Model& model, const StrayEvidence& cycle, double repeats,
                 double systematic, StrayDipole& dipole) noexcept;

// A scan from whose measurement the dipole's field was subtracted. step_s: since the previous scan.
void FollowDipole(const DipoleOptions& options, const Model& model, const StrayScan& scan, double repeats,
                  double systematic, double step_s, StrayDipole& dipole) noexcept;

// Its field in the readings, without the part common to all sensors.
ReadingLanes FieldOfDipole(const Model& model, const StrayDipole& dipole) noexcept;
void OffsetsOfDipole(const DipoleOptions& options, const Model& model, const StrayDipole& dipole, ReadingLanes& mean_T,
                     ReadingMatrix& covariance_T2) noexcept;

}  // namespace omni::tracker
