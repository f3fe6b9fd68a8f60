// Rows passed from a program to `omni-bench`, which runs it. JSON has no NaN: a figure that should have been measured
// and was not is passed as a string and becomes NaN again there, unlike one that has no meaning in its row (null).
#pragma once

#include <cmath>
#include <iostream>
#include <limits>
#include <nlohmann/json.hpp>
#include <string>

namespace omni::bench {

inline constexpr const char* kNotMeasuredWord = "not measured";

// As one JSON array.
template <class Rows>
void PrintRows(const Rows& rows) {
  auto printed = nlohmann::ordered_json::array();
  for (nlohmann::ordered_json row : rows) {
    for (auto& [key, value] : row.items()) {
      if (value.is_number_float() && !std::isfinite(value.template get<double>())) value = kNotMeasuredWord;
    }
    printed.push_back(row);
  }
  std::cout << printed.dump(1) << "\n";
}

inline void ReadNotMeasured(nlohmann::ordered_json& rows) {
  for (nlohmann::ordered_json& row : rows) {
    for (auto& [key, value] : row.items()) {
      if (value == kNotMeasuredWord) value = std::numeric_limits<double>::quiet_NaN();
    }
  }
}

}  // namespace omni::bench
