#include "service/room/sensor_watch.h"

#include <algorithm>

#include "service/base/clock.h"

namespace omni::room {
namespace {

constexpr double kCalibrationError = 0.01;  // what a calibration may get wrong
constexpr double kAmbient_T = 5e-5;

std::vector<std::pair<int, int>> Exchanges() {
  std::vector<std::pair<int, int>> all{{-1, -1}};
  for (int a = 0; a < base::kSensorCount; ++a) {
    for (int b = a + 1; b < base::kSensorCount; ++b) all.emplace_back(a, b);
  }
  return all;
}

tracker::StaticOptions Options() {
  tracker::StaticOptions options;
  options.trust.model_error_relative = kCalibrationError;
  options.trust.coil_error_relative = kCalibrationError;
  options.trust.ambient_error_T = kAmbient_T;
  return options;
}

}  // namespace

SwapSearch::SwapSearch(const base::Calibration& calibration) {
  auto solver = tracker::StaticSolver::Make(calibration, Options());
  if (solver.ok()) solver_.emplace(std::move(*solver));
}

void SwapSearch::Keep(const base::HallScan& scan) {
  if (scans_.size() >= kScans) return;
  if (!scans_.empty() && base::StampDifference_ns(scan.t_ns, scans_.back().t_ns) < kApart_ns) return;
  scans_.push_back(scan);
}

bool SwapSearch::Step() {
  static const std::vector<std::pair<int, int>> exchanges = Exchanges();
  if (!solver_ || scans_.size() < kScans) return false;
  for (int n = 0; n < kPairsAtOnce && fits_.size() < exchanges.size(); ++n) {
    const auto [a, b] = exchanges[fits_.size()];
    fits_.push_back(Fits(a, b));
  }
  if (fits_.size() < exchanges.size()) return false;
  const auto best = std::max_element(fits_.begin(), fits_.end());
  const auto others = std::count_if(fits_.begin(), fits_.end(), [](int fits) { return fits > kOthers; });
  found_.reset();
  if (best != fits_.begin() && *best >= kFits && others == 1) {
    found_ = exchanges[static_cast<std::size_t>(best - fits_.begin())];
  }
  scans_.clear();
  fits_.clear();
  return true;
}

void SwapSearch::Forget() {
  scans_.clear();
  fits_.clear();
  found_.reset();
}

int SwapSearch::Fits(int a, int b) const {
  int fits = 0;
  for (const base::HallScan& scan : scans_) {
    std::array<tracker::ArrayReading, base::kSensorCount> readings;
    for (std::size_t i = 0; i < readings.size(); ++i) {
      readings[i] = {scan.field_sensor_T[i], (scan.saturated_mask >> (3 * i)) & 7u};
    }
    if (a >= 0) std::swap(readings[static_cast<std::size_t>(a)], readings[static_cast<std::size_t>(b)]);
    const auto pose = solver_->Solve(readings, scan.coil_current_A);
    fits += pose.status == tracker::StaticStatus::kFound ? 1 : 0;
  }
  return fits;
}

}  // namespace omni::room
