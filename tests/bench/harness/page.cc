#include "tests/bench/harness/page.h"

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <set>
#include <sstream>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/tools/common/command_line.h"
#include "service/tools/common/files.h"
#include "service/tools/common/row_table.h"
#include "tests/bench/harness/commands.h"

namespace omni::bench {
namespace {

using nlohmann::ordered_json;

constexpr const char* kPlaceBegin = "<!-- results: ";
constexpr const char* kPlaceClose = " -->";
constexpr const char* kPlaceEnd = "<!-- end -->";

std::string PageCell(const ordered_json& value) {
  if (value.is_null()) return "-";
  if (value.is_number_float()) {
    char text[32];
    std::snprintf(text, sizeof(text), "%.4g", value.get<double>());
    return text;
  }
  std::string text = value.is_string() ? value.get<std::string>() : value.dump();
  for (std::size_t at = 0; (at = text.find('|', at)) != std::string::npos; at += 2) text.insert(at, "\\");
  return text;
}

std::string PageTable(const std::vector<ordered_json>& rows) {
  std::vector<std::string> keys;
  for (const ordered_json& row : rows) {
    for (const auto& [key, value] : row.items()) {
      if (!value.is_null() && std::find(keys.begin(), keys.end(), key) == keys.end()) keys.push_back(key);
    }
  }
  std::string head = "|", rule = "|", body;
  for (const std::string& key : keys) {
    head += " " + key + " |";
    rule += "---|";
  }
  for (const ordered_json& row : rows) {
    body += "|";
    for (const std::string& key : keys) body += " " + PageCell(row.value(key, ordered_json())) + " |";
    body += "\n";
  }
  return head + "\n" + rule + "\n" + body;
}

// Flat objects of `list`; with `section`, those of that section, without the key.
std::vector<ordered_json> RowsOf(const ordered_json& list, const std::string& section) {
  std::vector<ordered_json> rows;
  if (!list.is_array()) return rows;
  for (ordered_json row : list) {
    if (!row.is_object()) continue;
    if (!section.empty()) {
      if (row.value("section", ordered_json()) != section) continue;
      row.erase("section");
    }
    rows.push_back(std::move(row));
  }
  return rows;
}

// `place` without the document's name: "", "/TABLE" or ":KEY".
std::vector<ordered_json> FindRows(const ordered_json& document, const std::string& place) {
  if (!document.is_object() || !document.contains("rows")) return {};
  if (place.empty()) return RowsOf(document["rows"], "");
  const std::string table = place.substr(1);
  if (place.front() == ':') {
    std::vector<ordered_json> rows = RowsOf(document["rows"], "");
    std::erase_if(rows, [&table](const ordered_json& row) { return row.value(table, ordered_json()).is_null(); });
    return rows;
  }
  const ordered_json tables = document.value("tables", ordered_json::object());
  if (tables.is_object() && tables.contains(table)) return RowsOf(tables[table], "");
  return RowsOf(document["rows"], table);
}

std::string OriginOf(const ordered_json& document) {
  return "Made by `" + document.value("command", "?") + "`, commit " + document.value("commit", "?") + ", on " +
         document.value("machine", "?") + ":\n";
}

// The name in a line that opens a place; empty if it opens none.
std::string PlaceName(const std::string& line) {
  const std::size_t begin = std::strlen(kPlaceBegin);
  if (line.rfind(kPlaceBegin, 0) != 0) return {};
  const std::size_t close = line.find(kPlaceClose, begin);
  return close == std::string::npos ? std::string() : line.substr(begin, close - begin);
}

base::Result<std::string> ReadPage(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  if (!file) return base::Error{path + ": cannot be read (" + std::strerror(errno) + "); check the path"};
  return text.str();
}

base::Result<BenchDocuments> ReadDocuments(const std::vector<std::string>& paths) {
  BenchDocuments documents;
  for (const std::string& path : paths) {
    const auto text = tools::ReadJsonFile(path, tools::kRowsJson);
    if (!text.ok()) return base::Error{text.error()};
    ordered_json document = ordered_json::parse(*text);
    if (!document.is_object() || !document.contains("rows")) {
      return base::Error{
          path + ": no benchmark document ({name, commit, machine, rows}); make it with omni-bench NAME --json"};
    }
    documents[std::filesystem::path(path).stem().string()] = std::move(document);
  }
  return documents;
}

struct PageArguments {
  std::vector<std::string> files;
  std::string page = "docs/benchmarks.md";
};

// Empty, or why not.
std::string FillPageFile(const std::string& page, const std::vector<std::string>& files) {
  const auto documents = ReadDocuments(files);
  if (!documents.ok()) return documents.error();
  const auto text = ReadPage(page);
  if (!text.ok()) return text.error();
  const auto filled = FillPage(*text, *documents);
  if (!filled.ok()) return page + ": " + filled.error();
  const base::Status saved = tools::WriteWholeFile(page, *filled, true);
  return saved.ok() ? std::string() : saved.error();
}

int RunPage(const PageArguments& arguments) {
  const std::string problem = FillPageFile(arguments.page, arguments.files);
  return problem.empty() ? tools::kExitOk : tools::Fail("omni-bench page", problem);
}

}  // namespace

base::Result<std::string> FillPage(const std::string& page, const BenchDocuments& documents) {
  std::set<std::string> placed;
  std::istringstream lines(page);
  std::string filled;
  for (std::string line; std::getline(lines, line);) {
    filled += line + "\n";
    const std::string name = PlaceName(line);
    if (name.empty()) continue;
    const std::size_t own = std::min(name.find_first_of("/:"), name.size());
    const auto document = documents.find(name.substr(0, own));
    const bool given = document != documents.end();
    if (given) {
      placed.insert(document->first);
      const auto rows = FindRows(document->second, name.substr(own));
      if (rows.empty()) return base::Error{"results: " + name + ": the document has no such rows; check the name"};
      filled += OriginOf(document->second) + "\n" + PageTable(rows);
    }
    while (std::getline(lines, line) && line != kPlaceEnd) {
      if (!given) filled += line + "\n";
    }
    if (line != kPlaceEnd) return base::Error{"results: " + name + ": no line " + kPlaceEnd + " follows"};
    filled += line + "\n";
  }
  for (const auto& [name, document] : documents) {
    if (!placed.contains(name)) return base::Error{"no line " + (kPlaceBegin + name) + kPlaceClose + " for " + name};
  }
  return filled;
}

void AddPage(Command& app) {
  Command page = app.AddCommand("page", "put tables of JSON files of omni-bench into a page of Markdown");
  auto arguments = std::make_shared<PageArguments>();
  page.Add("files", arguments->files, "JSON files; solver.json goes where the page says <!-- results: solver -->")
      .Required();
  page.Add("-o,--output", arguments->page, "the page").ShowDefault();
  page.Run(arguments, RunPage);
}

}  // namespace omni::bench
