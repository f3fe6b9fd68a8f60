// What pictures of benchmarks share: rows of a document, and one box over the document's origin.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/harness/plot.h"

namespace omni::bench {

// A field of a row. A row may be anything: the file may be another's. Empty, or not a number: not there.
std::string RowWord(const nlohmann::json& row, const char* key);
double RowValue(const nlohmann::json& row, const char* key);

// Commit and machine of a document.
std::string BenchOrigin(const nlohmann::json& document);

// One box with its legend, under the bench's name and over the document's origin: an SVG.
std::string BenchChart(const nlohmann::json& document, const std::string& title, const PlotAxis& x, const PlotAxis& y,
                       const std::vector<PlotSeries>& series, double width_px);

}  // namespace omni::bench
