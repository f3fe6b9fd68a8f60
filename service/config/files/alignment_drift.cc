#include "service/config/files/alignment_drift.h"

#include <algorithm>
#include <cmath>

namespace omni::config {
namespace {

constexpr double kGuessWeight = 0.25;

double Square(double x) noexcept { return x * x; }

}  // namespace

double ErrorNow_m(double expected_error_m, const AlignmentDrift& drift) noexcept {
  return std::sqrt(Square(std::max(expected_error_m, drift.checked_m)) + drift.starts * Square(drift.per_start_m));
}

bool HasDrifted(double expected_error_m, const AlignmentDrift& drift) noexcept {
  return ErrorNow_m(expected_error_m, drift) > std::max(kMostAlignmentError_m, kMostAlignmentGrowth * expected_error_m);
}

AlignmentDrift Checked(AlignmentDrift drift, double offset_m, double expected_error_m, bool corrected) noexcept {
  if (drift.starts > 0) {
    const double known_m = std::max(expected_error_m, drift.checked_m);
    const double seen = std::max(0.0, Square(offset_m) - Square(known_m) - Square(kCheckError_m)) / drift.starts;
    const double weight = kGuessWeight + drift.checks;
    drift.per_start_m = std::sqrt((weight * Square(drift.per_start_m) + seen) / (weight + 1));
    ++drift.checks;
  }
  drift.starts = 0;
  drift.checked_m = corrected ? kCheckError_m : offset_m;
  return drift;
}

}  // namespace omni::config
