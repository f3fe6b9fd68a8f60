// Short scripts and files for tests that use the digital twin.
#pragma once

#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "service/sim/twin/twin.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::support {

// A pen held still, axis down, tip at `tip_m`.
inline sim::HandScript Holding(const base::Vec3& tip_m) {
  sim::HandScript script;
  script.name = "holding";
  script.waypoints = {{0, tip_m, {0, 0, -1}, true}};
  return script;
}

inline sim::TwinOptions HoldingTwin(const base::Vec3& tip_m) {
  sim::TwinOptions options;
  options.script = Holding(tip_m);
  options.real_time = false;
  return options;
}

// A CSV of numbers.
struct Table {
  std::vector<std::string> columns;
  std::vector<std::vector<double>> rows;

  std::size_t Column(const std::string& name) const {
    for (std::size_t i = 0; i < columns.size(); ++i) {
      if (columns[i] == name) return i;
    }
    std::abort();
  }
  double At(std::size_t row, const std::string& name) const { return rows.at(row).at(Column(name)); }
};

inline Table ReadTable(const std::string& path) {
  Table table;
  std::ifstream file(path);
  std::string line;
  std::string cell;
  if (std::getline(file, line)) {
    std::istringstream cells(line);
    while (std::getline(cells, cell, ',')) table.columns.push_back(cell);
  }
  while (std::getline(file, line)) {
    std::istringstream cells(line);
    std::vector<double> row;
    while (std::getline(cells, cell, ',')) row.push_back(std::strtod(cell.c_str(), nullptr));
    table.rows.push_back(row);
  }
  return table;
}

}  // namespace omni::support
