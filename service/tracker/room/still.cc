#include "service/tracker/room/drift.h"

#include <algorithm>
#include <cmath>

#include "service/base/eigen.h"
#include "service/base/vec.h"
#include "service/tracker/kernel/cholesky.h"
#include "service/tracker/kernel/matrices.h"

namespace omni::tracker {
namespace {

constexpr double kKnown = 1e-6;  // of a state's variance, when nothing has changed: none, but it needs an inverse

// The mean of the places so far: with one place alone, its noise would pass for the pen's next movement.
void SettleAt(const PenPlace& pen, double weight, PenPlace& place) noexcept {
  const auto settle = [&](const base::Vec3& towards, base::Vec3& at) {
    at = base::FromEigen(base::ToEigen(at) + weight * (base::ToEigen(towards) - base::ToEigen(at)));
  };
  settle(pen.position_base_m, place.position_base_m);
  settle(pen.axis_base, place.axis_base);
  settle(pen.core_A, place.core_A);
}

// d = (sum I)^-1 sum g; false: the sums do not determine it
bool SolveReference(StillPen& still) noexcept {
  SmallCholesky<kDriftStates> factors;
  if (!factors.Factor(still.information.data(), kDriftStates, 0)) return false;
  still.reference = factors.Solve(still.gradient);
  return true;
}

void BeginChanges(const DriftMatrix& covariance, StillPen& still) noexcept {
  still.covariance = {};
  still.reference_covariance = covariance;
  AsMatrix<kDriftStates>(still.covariance).diagonal() = kKnown * AsMatrix<kDriftStates>(covariance).diagonal();
  still.referenced = true;
}

void Gather(const DriftEvidence& evidence, StillPen& still) noexcept {
  AsVector(still.information) += AsVector(evidence.information);
  AsVector(still.gradient) += AsVector(evidence.gradient);
}

}  // namespace

double ForgottenOf(const StillOptions& options, double dt_s, const PenPlace* pen, double core_kept_A,
                   StillPen& still) noexcept {
  if (pen == nullptr) {
    still = {};
    return dt_s / options.forget_s;
  }
  still.still_s += dt_s;
  const double went_m = base::Distance(pen->position_base_m, still.place.position_base_m);
  const double turned_rad = base::Distance(pen->axis_base, still.place.axis_base);
  if (went_m < std::max(options.share * options.length_m, options.sigmas * pen->position_sigma_m) &&
      turned_rad < std::max(options.share * options.angle_rad, options.sigmas * pen->axis_sigma_rad)) {
    if (dt_s > 0 && still.still_s < options.settle_s) SettleAt(*pen, dt_s / still.still_s, still.place);
    return 0;
  }
  const double way = went_m / options.length_m + turned_rad / options.angle_rad;
  const double times = core_kept_A > 0 ? base::Distance(pen->core_A, still.place.core_A) / core_kept_A
                                       : std::min(way, still.still_s / options.forget_s);
  still = {};
  still.place = *pen;
  return times;
}

void ReduceToChange(const StillOptions& options, const DriftMatrix& covariance, StillPen& still,
                    DriftEvidence& evidence) noexcept {
  const double gathered_s = still.still_s - options.settle_s;
  if (gathered_s < 0) return;
  if (still.gathers && gathered_s < options.reference_max_s) {
    Gather(evidence, still);
    if (gathered_s >= options.reference_s) {
      if (!SolveReference(still)) {
        still = {};
        return;
      }
      if (!still.referenced) return BeginChanges(covariance, still);
    }
  }
  if (!still.referenced) return;
  AsVector(evidence.gradient) -= AsMatrix<kDriftStates>(evidence.information) * AsVector(still.reference);
  evidence.share = 1;
}

}  // namespace omni::tracker
