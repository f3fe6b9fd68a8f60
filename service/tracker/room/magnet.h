// Which pen is used: the moment of its magnet, and the magnets that are known from before. A pen can only be exchanged
// while there is none near the base. docs/theory/tracking.md, Other pens
#pragma once

#include <array>
#include <type_traits>

#include "service/base/tool_state.h"
#include "service/tracker/room/drift.h"

namespace omni::tracker {

struct KnownMagnet {
  double moment_scale = 1;  // of the model's moment
  double sigma = 0;         // its standard deviation
};
inline constexpr int kKnownMagnetsMax = 8;

struct MagnetOptions {
  bool enabled = true;
  // Known beside the calibrated one.
  std::array<KnownMagnet, kKnownMagnetsMax> known{};
  int known_count = 0;
  double warmth = 0.01;        // rms change of a moment with the magnet's temperature
  double unknown = 0.2;        // standard deviation of the moment of a pen of which nothing is known
  double furthest = 0.35;      // from the calibrated moment: beyond, it is no pen's
  double identified = 0.0125;  // standard deviation from which on a moment says which magnet it is
  double odd_sigmas = 3;       // of one scan: more contradicts the magnet that was there last
  double same_sigmas = 2;      // from a known magnet: within, it is that one
  double learnt_s = 10;        // tracked, until a new magnet counts as known
  // A pen may have been exchanged after so long without a pose and with so weak a field, or without a pose at all.
  double away_s = 0.1, away_T = 1e-4, absent_s = 1;
};

struct Magnet {
  static constexpr int kNone = -1;
  std::array<KnownMagnet, kKnownMagnetsMax> known{};
  int known_count = 0;  // 0: not enabled
  bool identified = false;
  int which = 0;           // of `known`: 0 is the calibrated one; kNone: a new one
  double foreign_s = 0;    // > 0: there is one, but it is no pen's, and nothing else is tried
  double last_moment = 0;  // relative change, when it was last identified
  double tracked_s = 0;    // of a new one
  double away_s = 0, absent_s = 0;
  std::array<double, kParameters> pose_per_moment{};  // shift of the pose with a relative change of the moment
};
static_assert(std::is_trivially_copyable_v<Magnet>);

// learns: the moment is estimated at all; else, or if not enabled, every pen counts as the calibrated one.
void StartMagnet(const MagnetOptions& options, bool learns, Magnet& magnet) noexcept;

// The pen may be another one from now on.
void ForgetMagnet(Magnet& magnet) noexcept;

// It is the one that was there last.
void ConfirmMagnet(DriftState& drift, Magnet& magnet) noexcept;

// A new one may still turn out to be a known one.
inline bool IsToBeIdentified(const Magnet& magnet) noexcept {
  return !magnet.identified || magnet.which == Magnet::kNone;
}

// Once the moment is known well enough: which magnet it is, and what is known of that one.
void IdentifyMagnet(const MagnetOptions& options, DriftState& drift, Magnet& magnet) noexcept;

// Once per scan, after it was published: whether a pen may have been exchanged, and whether a new one is known now.
// sensor_is_wrong: which by itself may leave scans without a pose.
void FollowMagnet(const MagnetOptions& options, const base::ToolState& tool, double dt_s, bool sensor_is_wrong,
                  const DriftState& drift, Magnet& magnet) noexcept;

// Variance of the moment that a pose's covariance has to contain: none of a magnet that is known.
double PublishedVariance(const DriftState& drift, const Magnet& magnet) noexcept;

// For reports.
void ReportMagnet(const DriftState& drift, const Magnet& magnet, base::ToolState& tool) noexcept;

}  // namespace omni::tracker
