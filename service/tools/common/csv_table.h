// A CSV recording (header line, numbers) as columns of doubles: the twin's truth and the loop's estimates.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::tools {

class CsvTable {
 public:
  // Errors name the file, the line and the column. A last line cut off by a killed writer is left out.
  static base::Result<CsvTable> Read(const std::string& path);

  std::size_t rows() const { return rows_; }
  bool Has(const std::string& column) const { return columns_.count(column) != 0; }
  // Precondition: Has(column).
  const std::vector<double>& operator[](const std::string& column) const { return columns_.at(column); }
  // Names of `wanted` that are missing, joined; empty: all there.
  std::string Missing(const std::vector<std::string>& wanted) const;

 private:
  std::map<std::string, std::vector<double>> columns_;
  std::size_t rows_ = 0;
};

}  // namespace omni::tools
