#include "service/tools/track/track_table.h"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string_view>

namespace omni::tools {
namespace {

constexpr std::size_t kMaxRows = 10'000'000;

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> fields;
  for (;;) {
    const std::size_t comma = line.find(',');
    fields.push_back(Trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

// Text from a file for terminals: shortened, without control characters.
std::string Quoted(std::string_view text) {
  std::string quoted = "\"";
  for (const char c : text.substr(0, 40)) quoted += c >= 0x20 && c < 0x7F ? c : '?';
  return quoted + "\"";
}

std::string Listed(const std::vector<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

// Empty: `value` is set.
std::string ParseNumber(std::string_view text, double& value) {
  if (text.empty()) return "is empty";
  const auto parsed = std::from_chars(text.data(), text.data() + text.size(), value);
  if (parsed.ec != std::errc{} || parsed.ptr != text.data() + text.size())
    return "= " + Quoted(text) + " is not a number";
  return std::isfinite(value) ? "" : "= " + Quoted(text) + " is not finite";
}

}  // namespace

base::Result<TrackTable> TrackTable::Read(const std::string& path) {
  std::error_code error;
  if (std::filesystem::exists(path, error) && !std::filesystem::is_regular_file(path, error)) {
    return base::Error{path + ": is not a regular file; name a .csv file"};
  }
  std::ifstream file(path);
  if (!file) return base::Error{path + ": cannot be read (" + std::strerror(errno) + "); check the path"};
  TrackTable table;
  table.path_ = path;
  std::string line;
  if (!std::getline(file, line)) return base::Error{path + ": is empty; a header line is expected"};
  for (const std::string_view field : Split(line)) {
    if (table.Has(std::string(field))) {
      return base::Error{path + ":1: column " + Quoted(field) + " appears twice; remove one"};
    }
    table.names_.emplace_back(field);
  }
  for (int number = 2; std::getline(file, line); ++number) {
    if (Trimmed(line).empty()) continue;
    const std::string where = path + ":" + std::to_string(number) + ": ";
    const std::vector<std::string_view> fields = Split(line);
    if (fields.size() != table.names_.size()) {
      return base::Error{where + std::to_string(fields.size()) + " fields, " + std::to_string(table.names_.size()) +
                         " expected; the line does not fit the header"};
    }
    if (table.lines_.size() == kMaxRows) {
      return base::Error{where + "more than " + std::to_string(kMaxRows) + " rows; split the recording"};
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      double value = 0;
      if (const std::string problem = ParseNumber(fields[i], value); !problem.empty()) {
        return base::Error{where + "column " + Quoted(table.names_[i]) + " " + problem +
                           "; every field must be a finite number: leave out poses with missing readings"};
      }
      table.values_.push_back(value);
    }
    table.lines_.push_back(number);
  }
  if (table.lines_.empty()) return base::Error{path + ": has a header but no rows"};
  return table;
}

std::size_t TrackTable::IndexOf(const std::string& column) const {
  return static_cast<std::size_t>(std::find(names_.begin(), names_.end(), column) - names_.begin());
}

std::string TrackTable::Where(std::size_t row) const { return path_ + ":" + std::to_string(lines_[row]) + ": "; }

base::Status TrackTable::Require(const std::vector<std::string>& columns) const {
  for (const std::string& column : columns) {
    if (!Has(column)) {
      return base::Error{path_ + ":1: column " + column + " is missing; the columns are: " + Listed(names_)};
    }
  }
  return base::Ok{};
}

base::Result<TrackTable::UnitColumn> TrackTable::ColumnWithUnit(const std::string& stem, const Unit* units,
                                                                std::size_t count) const {
  std::string allowed;
  UnitColumn found;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string name = stem + "_" + units[i].name;
    allowed += (allowed.empty() ? "" : ", ") + name;
    if (!Has(name)) continue;
    if (!found.unit.empty()) {
      return base::Error{path_ + ":1: columns " + stem + "_" + found.unit + " and " + name +
                         " give the same value in two units; keep one"};
    }
    found = {IndexOf(name), units[i].factor, units[i].name};
  }
  if (!found.unit.empty()) return found;
  return base::Error{path_ + ":1: column " + stem + " with its unit is missing; one of " + allowed +
                     " is expected, the columns are: " + Listed(names_)};
}

base::Result<TrackTable::UnitColumn> TrackTable::FieldColumn(const std::string& stem) const {
  static constexpr Unit kUnits[] = {{"T", 1}, {"mT", 1e-3}, {"uT", 1e-6}, {"G", 1e-4}, {"mG", 1e-7}};
  return ColumnWithUnit(stem, kUnits, std::size(kUnits));
}

base::Result<TrackTable::UnitColumn> TrackTable::LengthColumn(const std::string& stem) const {
  static constexpr Unit kUnits[] = {{"m", 1}, {"mm", 1e-3}};
  return ColumnWithUnit(stem, kUnits, std::size(kUnits));
}

base::Result<std::size_t> TrackTable::Count(std::size_t row, const std::string& column) const {
  const double value = At(row, column);
  if (!(value >= 0 && value <= 1e9 && value == std::floor(value))) {
    return base::Error{Where(row) + column + " = " + std::to_string(value) + "; must be a whole number >= 0"};
  }
  return static_cast<std::size_t>(value);
}

}  // namespace omni::tools
