#include "service/tracker/still.h"

#include <algorithm>
#include <cmath>

#include "service/base/distance.h"
#include "service/tracker/cholesky.h"
#include "service/tracker/drift.h"

namespace omni::tracker {
namespace {

constexpr std::size_t kStates = kDriftStates;
constexpr double kKnown = 1e-6;  // of a state's variance, when nothing has changed: none, but it needs an inverse

// d = (sum I)^-1 sum g
void TakeReference(const DriftMatrix& covariance, StillPen& still) noexcept {
  SmallCholesky<kDriftStates> factors;
  if (!factors.Factor(still.information.data(), kDriftStates, 0)) {
    still = {};
    return;
  }
  still.reference = factors.Solve(still.gradient);
  still.covariance = {};
  still.reference_covariance = covariance;
  for (std::size_t a = 0; a < kStates; ++a) {
    still.covariance[a * (kStates + 1)] = kKnown * covariance[a * (kStates + 1)];
  }
  still.referenced = true;
}

}  // namespace

double ForgottenOf(const StillOptions& options, double dt_s, const PenPlace* pen, StillPen& still) noexcept {
  if (pen == nullptr) {
    still = {};
    return dt_s / options.forget_s;
  }
  still.still_s += dt_s;
  const double went_m = base::Distance(pen->position_base_m, still.place.position_base_m);
  const double turned_rad = base::Distance(pen->axis_base, still.place.axis_base);
  if (went_m < std::max(options.share * options.length_m, options.sigmas * pen->position_sigma_m) &&
      turned_rad < std::max(options.share * options.angle_rad, options.sigmas * pen->axis_sigma_rad)) {
    return 0;
  }
  const double way = went_m / options.length_m + turned_rad / options.angle_rad;
  const double times = std::min(way, still.still_s / options.forget_s);
  still = {};
  still.place = *pen;
  return times;
}

void TellChange(const StillOptions& options, const DriftMatrix& covariance, StillPen& still,
                DriftEvidence& evidence) noexcept {
  if (still.referenced) {
    for (std::size_t a = 0; a < kStates; ++a) {
      for (std::size_t b = 0; b < kStates; ++b) {
        evidence.gradient[a] -= evidence.information[a][b] * still.reference[b];
      }
    }
    evidence.share = 1;
    return;
  }
  if (still.still_s < options.settle_s) return;
  for (std::size_t a = 0; a < kStates; ++a) {
    for (std::size_t b = 0; b < kStates; ++b) still.information[a * kStates + b] += evidence.information[a][b];
    still.gradient[a] += evidence.gradient[a];
  }
  if (still.still_s >= options.settle_s + options.reference_s) TakeReference(covariance, still);
}

}  // namespace omni::tracker
