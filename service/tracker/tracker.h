// The tracker: one Hall scan in, the tool's 5-DoF pose out. Fixed-size Levenberg-Marquardt on position and direction,
// then a filter of the hand's motion. docs/theory/tracking.md
#pragma once

#include <cstdint>
#include <type_traits>

#include "service/base/device_geometry.h"
#include "service/base/hall_scan.h"
#include "service/base/tool_state.h"
#include "service/tracker/filter/filter.h"
#include "service/tracker/kernel/measurement.h"
#include "service/tracker/kernel/model.h"
#include "service/tracker/room/away.h"
#include "service/tracker/room/doubt.h"
#include "service/tracker/room/drift.h"
#include "service/tracker/room/magnet.h"
#include "service/tracker/room/mains.h"
#include "service/tracker/room/stray_field.h"
#include "service/tracker/solve/pair_start.h"

namespace omni::tracker {

struct Config {
  Model model;                              // prepared by MakeConfig: sensors, coil maps, magnet, core
  Trust trust;                              // of the readings
  FilterNoise filter;                       // how a hand moves
  DriftNoise drift;                         // how fast offsets and moment change
  MagnetOptions magnets;                    // pens, and when another one is used
  MainsOptions mains;                       // a tone in the ambient field
  DoubtOptions doubt;                       // when a sensor or the calibration is doubted
  StrayOptions stray;                       // when a magnet nearby is accepted
  PairOptions pair;                         // when one may have been there from the start
  AwayOptions away;                         // what is learnt while no pen is near
  Precision precision = Precision::kFloat;  // of the sums; hidden currents always take double
  double chi2_max = 80;                     // gate at 19 degrees of freedom: larger = this scan does not fit
  double field_min_T = 4e-6;                // rms of the magnet's field over sensors; below: absent (0.5 m away)
  double ambient_max_T = 2e-4;              // of the field's change since calibration; more is a wrong pose
  int axes_min = 9;                         // fewer usable readings: no pose
  int dof_min = 6;                          // the same of degrees of freedom: a wrong pose would not show
  int iterations_max = 8;                   // warm
  int cold_iterations_max = 30;
  int cold_pause_scans = 8;    // between two failed cold starts
  double reach_min_m = 0.030;  // |position| outside [min, max] or below z_min_m: not a pose
  double reach_max_m = 0.250;
  double z_min_m = -0.030;
  double coast_max_s = 0.100;       // older than this, the last pose is no start for the next
  double velocity_decay_s = 0.010;  // published velocities while lost
  int lost_after_scans = 18;        // bad scans in a row before kAbsent: within 20 ms at 1 kHz
  double jump_max_m = 0.010;        // a fix further from the motion so far waits for jump_scans bad scans
  int jump_scans = 2;
  double coarse_m = 1e-3;      // kToolCoarse: standard deviation of one scan's position
  double tilted_cos = 0.2588;  // kToolTilted: |cosine| between axis and radius below this (75 degrees)
};

// What is known of the pen.
struct PoseState {
  bool ever_tracked = false;
  bool warm = false;  // `filter` belongs to filter_t_ns and may start the next fit
  int bad_scans = 0;  // in a row
  std::int64_t filter_t_ns = 0;
  std::uint32_t cold_scan = 0;  // the last whose pose was found by a cold start
  FilterState filter;
  base::ToolState published;  // the last output
};

// What is known of base and room, the same for many scans.
struct RoomState {
  std::uint32_t scans = 0;
  int old_scans = 0;                         // in a row: with the stamp of the previous scan
  CurrentHistory currents, currents_before;  // of the coils: with the last scan, and with the one before
  Repetition repetition;
  DriftState drift;
  DriftEvidence evidence;  // of the last scan, used by the next, so that no scan pays for both
  Magnet magnet;
  Mains mains;
  Doubt doubt;
  StrayField stray;
  Away away;
};

// Of the search for an explanation, over several scans.
struct SearchState {
  bool explained = false;           // some pose fitted the last scan that was tried, in reach or not
  int cold_pause = 0;               // scans to wait before the next cold start
  int cold_row = 0, cold_time = 0;  // of the next one: its hypothesis, and which time of it
  PairStart pair;
};

struct State {
  PoseState pose;
  RoomState room;
  SearchState search;
};
static_assert(std::is_trivially_copyable_v<State>);

Config MakeConfig(const base::Calibration& calibration);
Config MakeConfig(const base::DeviceGeometry& device);  // uncalibrated: nominal geometry

// Warm start from `state` (predicted to the scan's time), or cold start. Never throws, allocates or returns a
// non-finite pose: a scan that does not fit gives kLost (the last good pose, velocities fading) and, after
// lost_after_scans, kAbsent. A scan with an unchanged stamp changes only limits; lost_after_scans of them in a row mean
// a stopped clock and count as bad. A first fix is published only when its chi2 passes. The published covariance is the
// filter's: position block 3x3, tangents of magnetics::MakeTangentBasis(axis) 2x2, no cross terms. pushed: a force has
// acted on the pen since the previous scan.
void Update(const Config& config, const base::HallScan& scan, State& state, base::ToolState& tool,
            bool pushed = false) noexcept;

// Constant-velocity prediction of `tool` to t_ns, at most 20 ms away. gap_m and covariance stay those of the sample.
base::ToolState Predict(const base::ToolState& tool, std::int64_t t_ns, double tip_offset_m) noexcept;

}  // namespace omni::tracker
