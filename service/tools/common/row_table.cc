#include "service/tools/common/row_table.h"

#include <sys/utsname.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

namespace omni::tools {
namespace {

std::string Machine() {
  std::string model = "unknown CPU";
  std::ifstream cpuinfo("/proc/cpuinfo");
  for (std::string line; std::getline(cpuinfo, line);) {
    if (line.rfind("model name", 0) != 0) continue;
    model = line.substr(line.find(':') + 2);
    break;
  }
  utsname system{};
  uname(&system);
  return model + ", " + std::to_string(std::thread::hardware_concurrency()) + " threads, Linux " + system.release;
}

// The command line without --json FILE.
std::string CommandLine() {
  std::ifstream file("/proc/self/cmdline");
  std::string word;
  std::getline(file, word, '\0');
  std::string command = std::filesystem::path(word).filename().string();
  while (std::getline(file, word, '\0')) {
    if (word == "--json") {
      std::getline(file, word, '\0');
    } else {
      command += " " + word;
    }
  }
  return command;
}

std::string Cell(const nlohmann::ordered_json& value) {
  if (value.is_string()) return value;
  if (value.is_null()) return "-";
  if (!value.is_number_float()) return value.dump();
  if (!std::isfinite(value.get<double>())) return "-";
  char text[32];
  std::snprintf(text, sizeof(text), "%.3f", value.get<double>());
  return text;
}

// The row's text values, which identify it.
std::string WordsOf(const nlohmann::ordered_json& row) {
  std::string words;
  for (const auto& [key, value] : row.items()) {
    if (value.is_string()) words += (words.empty() ? "" : ", ") + value.get<std::string>();
  }
  return words;
}

}  // namespace

std::vector<std::string> NotMeasured(const Rows& rows) {
  std::vector<std::string> names;
  for (const auto& row : rows) {
    for (const auto& [key, value] : row.items()) {
      if (!value.is_number_float() || std::isfinite(value.get<double>())) continue;
      names.push_back(key + " of " + WordsOf(row));
    }
  }
  return names;
}

std::vector<std::pair<std::string, Rows>> TakeSideTables(Rows& rows) {
  std::vector<std::pair<std::string, Rows>> tables;
  Rows kept;
  for (nlohmann::ordered_json& row : rows) {
    if (!row.contains("table")) {
      kept.push_back(row);
      continue;
    }
    const std::string name = row["table"];
    row.erase("table");
    const auto same = [&name](const auto& table) { return table.first == name; };
    auto found = std::find_if(tables.begin(), tables.end(), same);
    if (found == tables.end()) found = tables.insert(tables.end(), {name, {}});
    found->second.push_back(row);
  }
  rows = kept;
  return tables;
}

nlohmann::ordered_json RowDocument(const std::string& name, const Rows& rows) {
  Rows own = rows;
  const auto tables = TakeSideTables(own);
  nlohmann::ordered_json document{
      {"name", name}, {"command", CommandLine()}, {"commit", OMNI_COMMIT}, {"machine", Machine()}, {"rows", own}};
  for (const auto& [table, side] : tables) document["tables"][table] = side;
  return document;
}

std::string RowTable(const Rows& rows) {
  if (rows.empty()) return "no rows\n";
  std::vector<std::string> keys;
  for (const auto& [key, value] : rows.front().items()) keys.push_back(key);
  std::vector<std::vector<std::string>> lines{keys};
  for (const auto& row : rows) {
    std::vector<std::string> line;
    line.reserve(keys.size());
    for (const std::string& key : keys) line.push_back(Cell(row.value(key, nlohmann::ordered_json())));
    lines.push_back(line);
  }
  std::string text;
  for (const auto& line : lines) {
    for (std::size_t column = 0; column < keys.size(); ++column) {
      std::size_t width = 0;
      for (const auto& other : lines) width = std::max(width, other[column].size());
      text += line[column] + std::string(width + 2 - line[column].size(), ' ');
    }
    text.erase(text.find_last_not_of(' ') + 1);
    text += "\n";
  }
  return text;
}

}  // namespace omni::tools
