#include "service/tools/track/track_table.h"

#include <algorithm>
#include <cctype>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <string_view>
#include <utility>

namespace omni::tools {
namespace {

constexpr std::size_t kMaxRows = 10'000'000;

std::string_view Trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r')) text.remove_suffix(1);
  return text;
}

// Fields between commas; in quotes they may have commas, and "" is a quote [RFC 4180].
std::vector<std::string> Split(std::string_view line) {
  std::vector<std::string> fields;
  std::string field;
  bool quoted = false, was_quoted = false;
  const auto end_field = [&] {
    fields.emplace_back(was_quoted ? std::string_view(field) : Trimmed(field));
    field.clear();
    was_quoted = false;
  };
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (quoted && c == '"' && i + 1 < line.size() && line[i + 1] == '"') {
      field += line[++i];
    } else if (c == '"' && (quoted || Trimmed(field).empty())) {
      if (!quoted) field.clear();
      quoted = !quoted;
      was_quoted = true;
    } else if (c == ',' && !quoted) {
      end_field();
    } else if (!was_quoted || quoted) {
      field += c;
    }
  }
  end_field();
  return fields;
}

void Replace(std::string& text, std::string_view from, std::string_view to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size()) {
    text.replace(at, from.size(), to);
  }
}

// "Bx (uT)", "bx [µT]" -> "bx_uT"
std::string ColumnName(std::string_view field) {
  std::string name(Trimmed(field));
  Replace(name, "\u00b5", "u");  // micro sign
  Replace(name, "\u03bc", "u");  // Greek mu
  const std::size_t open = name.find_last_of("([");
  if (open != std::string::npos && open > 0 && (name.back() == ')' || name.back() == ']')) {
    const std::string unit(Trimmed(std::string_view(name).substr(open + 1, name.size() - open - 2)));
    name = std::string(Trimmed(std::string_view(name).substr(0, open))) + "_" + unit;
  }
  const std::size_t stem = std::min(name.find_last_of('_'), name.size());
  for (std::size_t i = 0; i < stem; ++i) name[i] = static_cast<char>(std::tolower(static_cast<unsigned char>(name[i])));
  return name;
}

// Empty: commas separate.
std::string SeparatorProblem(std::string_view header) {
  if (header.find(',') != std::string_view::npos) return {};
  for (const auto& [mark, name] : {std::pair{';', "\";\""}, {'\t', "a tab"}, {'|', "\"|\""}, {' ', "a space"}}) {
    if (header.find(mark) == std::string_view::npos) continue;
    return std::string("fields are separated by ") + name + "; separate them by commas, with points in the numbers";
  }
  return {};
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
  if (text.size() > 1 && text[0] == '+' && text[1] != '-' && text[1] != '+') text.remove_prefix(1);
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
  int number = 0;
  const auto next = [&] {
    while (std::getline(file, line)) {
      if (++number == 1 && line.starts_with("\xEF\xBB\xBF")) line.erase(0, 3);
      if (!Trimmed(line).empty() && Trimmed(line)[0] != '#') return true;
    }
    return false;
  };
  if (!next()) return base::Error{path + ": is empty; a header line is expected"};
  const std::string first = path + ":" + std::to_string(number) + ": ";
  if (line.find('\0') != std::string::npos) return base::Error{first + "is not UTF-8; save the file as UTF-8"};
  if (const std::string problem = SeparatorProblem(Trimmed(line)); !problem.empty())
    return base::Error{first + problem};
  for (const std::string& field : Split(line)) {
    const std::string name = ColumnName(field);
    if (!name.empty() && table.Has(name)) {
      return base::Error{first + "column " + Quoted(name) + " appears twice; remove one"};
    }
    table.names_.push_back(name);
  }
  table.problems_.resize(table.names_.size());
  while (next()) {
    const std::string where = path + ":" + std::to_string(number) + ": ";
    const std::vector<std::string> fields = Split(line);
    if (fields.size() != table.names_.size()) {
      return base::Error{where + std::to_string(fields.size()) + " fields, " + std::to_string(table.names_.size()) +
                         " expected; the line does not fit the header (decimal commas? use points)"};
    }
    if (table.lines_.size() == kMaxRows) {
      return base::Error{where + "more than " + std::to_string(kMaxRows) + " rows; split the recording"};
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      double value = 0;
      const std::string problem = ParseNumber(Trimmed(fields[i]), value);
      if (!problem.empty() && table.problems_[i].empty()) {
        table.problems_[i] = where + "column " + Quoted(table.names_[i]) + " " + problem +
                             "; every field must be a finite number: leave out poses with missing readings";
      }
      table.values_.push_back(problem.empty() ? value : std::numeric_limits<double>::quiet_NaN());
    }
    table.lines_.push_back(number);
  }
  if (table.lines_.empty()) return base::Error{path + ": has a header but no rows"};
  return table;
}

std::size_t TrackTable::IndexOf(const std::string& column) const {
  return static_cast<std::size_t>(std::find(names_.begin(), names_.end(), ColumnName(column)) - names_.begin());
}

std::string TrackTable::Where(std::size_t row) const { return path_ + ":" + std::to_string(lines_[row]) + ": "; }

base::Status TrackTable::Require(const std::vector<std::string>& columns) const {
  for (const std::string& column : columns) {
    if (!Has(column)) {
      return base::Error{path_ + ":1: column " + column + " is missing; the columns are: " + Listed(names_)};
    }
    if (const std::string& problem = problems_[IndexOf(column)]; !problem.empty()) return base::Error{problem};
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
  if (!found.unit.empty() && !problems_[found.column].empty()) return base::Error{problems_[found.column]};
  if (!found.unit.empty()) return found;
  return base::Error{path_ + ":1: column " + stem + " with its unit is missing; one of " + allowed +
                     " is expected, the columns are: " + Listed(names_)};
}

base::Result<TrackTable::UnitColumn> TrackTable::FieldColumn(const std::string& stem) const {
  static constexpr Unit kUnits[] = {{"T", 1}, {"mT", 1e-3}, {"uT", 1e-6}, {"nT", 1e-9}, {"G", 1e-4}, {"mG", 1e-7}};
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
