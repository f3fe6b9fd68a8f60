#include "service/tools/common/files.h"

#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <string_view>

#include "service/base/files/whole_file.h"

namespace omni::tools {

base::Result<std::string> ReadJsonFile(const std::string& path, const base::JsonLimits& limits) {
  base::Result<std::string> text = base::ReadFile(path, limits.bytes);
  if (!text.ok()) return text;
  const base::Status checked = base::CheckJson(*text, limits);
  if (!checked.ok()) return base::Error{path + ": " + checked.error()};
  return text;
}

base::Status WriteWholeFile(const std::string& path, std::string_view content, bool overwrite) {
  const int error = base::PutWholeFile(path, {content}, {.replace = overwrite});
  if (error == 0) return base::Ok{};
  if (error == EEXIST) return base::Error{path + ": already exists; choose another name, or replace it with --force"};
  return base::Error{base::WriteProblem(path, error)};
}

std::string WriteText(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  file << text;
  file.close();
  return file ? std::string() : path + ": cannot be written (" + std::strerror(errno) + "); check the folder";
}

namespace {

std::vector<std::string_view> Split(std::string_view line) {
  std::vector<std::string_view> fields;
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(line.substr(0, comma));
    if (comma == std::string_view::npos) return fields;
    line.remove_prefix(comma + 1);
  }
}

}  // namespace

base::Result<CsvTable> CsvTable::Read(const std::string& path) {
  std::ifstream file(path);
  if (!file) return base::Error{path + ": " + std::strerror(errno)};
  std::string line;
  if (!std::getline(file, line)) return base::Error{path + ": empty; a header line is expected"};
  std::vector<std::string> names;
  for (const std::string_view field : Split(line)) names.emplace_back(field);
  std::vector<std::vector<double>> columns(names.size());
  for (int number = 2; std::getline(file, line); ++number) {
    const std::vector<std::string_view> fields = Split(line);
    if (file.eof() && fields.size() < names.size()) break;
    if (fields.size() != names.size()) {
      return base::Error{path + ":" + std::to_string(number) + ": " + std::to_string(fields.size()) + " fields, " +
                         std::to_string(names.size()) + " expected"};
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      double value = 0;
      const auto parsed = std::from_chars(fields[i].data(), fields[i].data() + fields[i].size(), value);
      const bool whole = parsed.ec == std::errc{} && parsed.ptr == fields[i].data() + fields[i].size();
      if (!whole && !fields[i].empty()) {
        return base::Error{path + ":" + std::to_string(number) + ": column " + names[i] + ": not a number"};
      }
      columns[i].push_back(value);
    }
  }
  CsvTable table;
  table.rows_ = columns.empty() ? 0 : columns[0].size();
  for (std::size_t i = 0; i < names.size(); ++i) table.columns_[names[i]] = std::move(columns[i]);
  return table;
}

std::string CsvTable::MissingColumns(const std::vector<std::string>& wanted) const {
  std::string missing;
  for (const std::string& column : wanted) {
    if (!HasColumn(column)) missing += (missing.empty() ? "" : ", ") + column;
  }
  return missing;
}

}  // namespace omni::tools
