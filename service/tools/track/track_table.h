// A CSV table as instruments, spreadsheets and scripts write it: a header line, then finite numbers in every column
// that is used; others may hold anything. Read as it is meant: a byte order mark, quotes [RFC 4180], "+1.5", lines that
// begin with #, and units as in "bx_uT", "Bx (uT)" or "bx [µT]". For third-party recordings; recordings of our own runs
// are read by files.h. Errors name file, line, column, value and remedy.
#pragma once

#include <string>
#include <vector>

#include "service/base/result.h"

namespace omni::tools {

class TrackTable {
 public:
  static base::Result<TrackTable> Read(const std::string& path);

  const std::string& path() const { return path_; }
  std::size_t rows() const { return lines_.size(); }
  // Stem in lower case, then the unit: "bx_uT".
  const std::vector<std::string>& names() const { return names_; }
  bool Has(const std::string& column) const { return IndexOf(column) < names_.size(); }
  // Precondition: Require, FieldColumn or LengthColumn had no error for it.
  double At(std::size_t row, const std::string& column) const { return At(row, IndexOf(column)); }
  double At(std::size_t row, std::size_t column) const { return values_[row * names_.size() + column]; }
  std::size_t IndexOf(const std::string& column) const;  // names().size(): absent

  // "file:line: ", of that row in the file.
  std::string Where(std::size_t row) const;

  // Error unless all are there, with a finite number in every row.
  base::Status Require(const std::vector<std::string>& columns) const;

  // A column `stem`_<unit> in any of the units that `stem` allows; SI value = factor * number.
  struct UnitColumn {
    std::size_t column = 0;
    double factor = 1;
    std::string unit;
  };
  base::Result<UnitColumn> FieldColumn(const std::string& stem) const;   // T, mT, uT, nT, G, mG
  base::Result<UnitColumn> LengthColumn(const std::string& stem) const;  // m, mm

  // A whole number >= 0; the error names row and column.
  base::Result<std::size_t> Count(std::size_t row, const std::string& column) const;

 private:
  struct Unit {
    const char* name;
    double factor;
  };
  base::Result<UnitColumn> ColumnWithUnit(const std::string& stem, const Unit* units, std::size_t count) const;

  std::string path_;
  std::vector<std::string> names_;
  std::vector<double> values_;
  std::vector<std::string> problems_;  // of each column: its first field that is no finite number; empty: none
  std::vector<int> lines_;             // line number in the file, per row
};

}  // namespace omni::tools
