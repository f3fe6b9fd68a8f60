// Errors of estimated poses against the twin's truth, collected for a row of a benchmark.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <string>
#include <vector>

#include "service/base/tool_state.h"
#include "service/base/vec.h"
#include "service/sim/fields/charges.h"
#include "service/sim/fields/vec3.h"
#include "service/tools/common/row_table.h"

namespace omni::bench {

// A pose further off than this, or of the wrong polarity, is a failure, not an estimate.
inline constexpr double kFailure_m = 0.010;
inline constexpr double kFailure_rad = 0.5 * std::numbers::pi;

// An error that a person notices, counted wherever poses are.
inline constexpr double kLarge_m = 0.002;
// An error beyond so many published standard deviations is silent.
inline constexpr double kSilentSigmas = 5;

struct PoseError {
  double position_m = 0;
  double axis_rad = 0;
  bool failed() const noexcept { return !(position_m <= kFailure_m && axis_rad <= kFailure_rad); }
};

inline PoseError ErrorOf(const sim::MagnetPose& truth, const base::Vec3& position, const base::Vec3& axis) noexcept {
  // atan2 keeps small angles exact, where acos of a rounded product does not.
  return {Norm(position - truth.centre_base_m),
          std::atan2(Norm(Cross(axis, truth.axis_base)), Dot(axis, truth.axis_base))};
}

inline bool IsSilent(const PoseError& error, const base::ToolState& tool) noexcept {
  const double sigma_m = std::sqrt(tool.covariance[0] + tool.covariance[6] + tool.covariance[12]);
  return !(error.position_m <= kSilentSigmas * sigma_m);
}

template <class T>
void Append(const std::vector<T>& from, std::vector<T>& to) {
  to.insert(to.end(), from.begin(), from.end());
}

struct ErrorSet {
  std::vector<double> position_mm;
  std::vector<double> axis_deg;
  std::size_t failures = 0;

  void Add(const PoseError& error) {
    position_mm.push_back(1e3 * error.position_m);
    axis_deg.push_back(error.axis_rad * 180 / std::numbers::pi);
    failures += error.failed() ? 1 : 0;
  }
  void Add(const ErrorSet& other) {
    Append(other.position_mm, position_mm);
    Append(other.axis_deg, axis_deg);
    failures += other.failures;
  }
  std::size_t LargerThan(double size_m) const {
    return static_cast<std::size_t>(
        std::count_if(position_mm.begin(), position_mm.end(), [&](double mm) { return mm > 1e3 * size_m; }));
  }
  // A scan without any estimate.
  void AddMissing() { ++failures; }
};

inline double Rms(const std::vector<double>& values) {
  double sum = 0;
  for (const double value : values) sum += value * value;
  return values.empty() ? tools::kNotMeasured : std::sqrt(sum / static_cast<double>(values.size()));
}

inline std::string SeedText(const std::vector<std::uint64_t>& seeds) {
  std::string text;
  for (const std::uint64_t seed : seeds) text += (text.empty() ? "" : " ") + std::to_string(seed);
  return text;
}

}  // namespace omni::bench
