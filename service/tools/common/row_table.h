// Figures as rows: aligned columns for people, flat JSON rows for machines.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/files/json_document.h"

namespace omni::tools {

// Rows are flat objects; keys in a stated order. A figure that has no meaning in its row is null; one that should have
// been measured and was not is NaN (or infinite), null in JSON too, and makes a benchmark fail. Rows with a key "table"
// do not belong to the main table: they go to side tables of that name.
using Rows = std::vector<nlohmann::ordered_json>;

// What a file of rows may hold.
inline constexpr base::JsonLimits kRowsJson{.bytes = 16 << 20, .values = 500'000, .depth = 32};

// Side tables in the order of their first row; `rows` keeps the others.
std::vector<std::pair<std::string, Rows>> TakeSideTables(Rows& rows);

// Aligned columns, one line per row.
std::string RowTable(const Rows& rows);

// Each figure that should have been measured and was not, as "key of the row's words"; empty: none.
std::vector<std::string> NotMeasured(const Rows& rows);

// {"name", "command", "commit", "machine", "rows"} and, when there are side tables, "tables": {name: rows}. `command`
// is this program's, without --json FILE.
nlohmann::ordered_json RowDocument(const std::string& name, const Rows& rows);

// Order statistics for reports and benchmarks. Without values they are NaN, which is null in JSON and "-" in a table:
// not measured is not zero.

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
