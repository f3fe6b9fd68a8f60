// Order statistics for reports and benchmarks. Without values they are NaN, which is null in JSON and "-" in a table:
// not measured is not zero.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <vector>

namespace omni::tools {

inline constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

// q-quantile by the nearest rank, q in [0, 1].
inline double Quantile(std::vector<double> values, double q) {
  if (values.empty()) return kNotMeasured;
  const auto rank = static_cast<std::ptrdiff_t>(
      std::clamp(std::ceil(q * static_cast<double>(values.size())) - 1, 0.0, static_cast<double>(values.size() - 1)));
  std::nth_element(values.begin(), values.begin() + rank, values.end());
  return values[static_cast<std::size_t>(rank)];
}

inline double Mean(const std::vector<double>& values) {
  if (values.empty()) return kNotMeasured;
  return std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size());
}

}  // namespace omni::tools
