#include "service/tracker/room/magnet.h"

#include <algorithm>
#include <cmath>

namespace omni::tracker {
namespace {

constexpr double kStep_s = 0.02;  // a longer one counts as this much: nothing is known of what happened

double SquareOf(double x) noexcept { return x * x; }

// The nearest known magnet, as a relative change of the moment. The one that was there last counts as it was then: it
// may be warm.
struct Nearest {
  int which = Magnet::kNone;
  double relative = 0, variance = 0;
};

Nearest NearestTo(const MagnetOptions& options, double relative, double variance, const Magnet& magnet) noexcept {
  Nearest nearest;
  double least = SquareOf(options.same_sigmas);
  const auto compare = [&](int which, double known, double known_variance) {
    const double distance = SquareOf(relative - known) / (variance + known_variance);
    if (!(distance <= least)) return;
    least = distance;
    nearest = {which, known, known_variance};
  };
  for (int k = 0; k < magnet.known_count; ++k) {
    const KnownMagnet& known = magnet.known[static_cast<std::size_t>(k)];
    compare(k, known.moment_scale - 1, SquareOf(known.sigma) + SquareOf(options.warmth));
  }
  if (magnet.which != Magnet::kNone) compare(magnet.which, magnet.last_moment, SquareOf(options.warmth));
  return nearest;
}

}  // namespace

void StartMagnet(const MagnetOptions& options, bool learns, Magnet& magnet) noexcept {
  magnet = {};
  magnet.identified = !(options.enabled && learns);
  if (magnet.identified) return;
  magnet.known[0] = {};
  magnet.known_count = 1;
  for (int k = 0; k < options.known_count && magnet.known_count < kKnownMagnetsMax; ++k) {
    magnet.known[static_cast<std::size_t>(magnet.known_count++)] = options.known[static_cast<std::size_t>(k)];
  }
}

void ForgetMagnet(Magnet& magnet) noexcept {
  if (magnet.known_count == 0) return;
  magnet.identified = false;
  magnet.away_s = magnet.absent_s = 0;
}

void ConfirmMagnet(DriftState& drift, Magnet& magnet) noexcept {
  magnet.identified = true;
  magnet.last_moment = MomentScale(drift) - 1;
  drift.moment_open = false;
}

void IdentifyMagnet(const MagnetOptions& options, DriftState& drift, Magnet& magnet) noexcept {
  if (!(MomentVariance(drift) <= SquareOf(options.identified))) return;
  const double relative = MomentScale(drift) - 1;
  const Nearest nearest = NearestTo(options, relative, MomentVariance(drift), magnet);
  if (nearest.which == Magnet::kNone && magnet.identified) return;
  if (nearest.which != Magnet::kNone) {
    ObserveMoment(nearest.relative, nearest.variance, drift);
  } else if (magnet.which != Magnet::kNone || std::abs(relative - magnet.last_moment) > options.warmth) {
    magnet.tracked_s = 0;
  }
  magnet.which = nearest.which;
  magnet.identified = true;
  magnet.last_moment = MomentScale(drift) - 1;
  HoldMoment(nearest.which == Magnet::kNone ? magnet.last_moment : nearest.relative, drift);
}

void FollowMagnet(const MagnetOptions& options, const base::ToolState& tool, double dt_s, bool sensor_is_wrong,
                  const DriftState& drift, Magnet& magnet) noexcept {
  if (magnet.known_count == 0) return;
  dt_s = dt_s >= 0 ? std::min(dt_s, kStep_s) : 0;
  if (tool.status != base::TrackingStatus::kTracking) {
    magnet.absent_s += sensor_is_wrong ? 0 : dt_s;
    magnet.away_s = tool.field_rms_T < options.away_T ? magnet.away_s + dt_s : 0;
    magnet.foreign_s = std::max(0.0, magnet.foreign_s - dt_s);
    if (magnet.identified && (magnet.away_s >= options.away_s || magnet.absent_s >= options.absent_s)) {
      ForgetMagnet(magnet);
    }
    return;
  }
  magnet.away_s = magnet.absent_s = 0;
  magnet.foreign_s = 0;
  if (!magnet.identified) return;
  magnet.last_moment = MomentScale(drift) - 1;
  if (magnet.which != Magnet::kNone) return;
  magnet.tracked_s += dt_s;
  if (magnet.tracked_s < options.learnt_s) return;
  const int last = kKnownMagnetsMax - 1;
  magnet.which = std::min(magnet.known_count, last);
  magnet.known_count = magnet.which + 1;
  magnet.known[static_cast<std::size_t>(magnet.which)] = {MomentScale(drift), std::sqrt(MomentVariance(drift))};
}

double PublishedVariance(const DriftState& drift, const Magnet& magnet) noexcept {
  return magnet.identified && magnet.which != Magnet::kNone ? 0.0 : MomentVariance(drift);
}

void ReportMagnet(const DriftState& drift, const Magnet& magnet, base::ToolState& tool) noexcept {
  tool.moment_scale = MomentScale(drift);
  tool.moment_sigma = std::sqrt(std::max(0.0, MomentVariance(drift)));
  tool.magnet = !magnet.identified || magnet.known_count == 0 ? base::MagnetIdentity::kUnknown
                : magnet.which == 0                           ? base::MagnetIdentity::kCalibrated
                : magnet.which > 0                            ? base::MagnetIdentity::kKnown
                                                              : base::MagnetIdentity::kNew;
}

}  // namespace omni::tracker
