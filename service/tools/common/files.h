// Files of subcommands: JSON that another program wrote, or an earlier run of ours, is checked against limits before it
// is parsed, so that it cannot exhaust the JSON library's parsers; a user's file is written completely or not at all.
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "service/base/files/json_document.h"
#include "service/base/result.h"

namespace omni::tools {

// Manifests of OpenXR, reports of applications.
inline constexpr base::JsonLimits kManifestJson{.bytes = 1 << 20, .values = 5'000, .depth = 32};

// The text of a file that is JSON within the limits. The error names the path.
base::Result<std::string> ReadJsonFile(const std::string& path, const base::JsonLimits& limits);

// An existing file is replaced only with `overwrite`, else refused and left as it is. The error names the path, the
// reason and what to do.
base::Status WriteWholeFile(const std::string& path, std::string_view content, bool overwrite);

// Results that can be made again: in place, also to a pipe or /dev/stdout. Empty: written. Else "PATH: cannot be
// written (REASON); check the folder".
std::string WriteText(const std::string& path, const std::string& text);

// A CSV recording (header line, numbers) as columns of doubles: the twin's truth and the loop's estimates.
class CsvTable {
 public:
  // Errors name the file, the line and the column. A last line cut off by a killed writer is left out.
  static base::Result<CsvTable> Read(const std::string& path);

  std::size_t rows() const { return rows_; }
  bool HasColumn(const std::string& column) const { return columns_.count(column) != 0; }
  // Precondition: HasColumn(column).
  const std::vector<double>& operator[](const std::string& column) const { return columns_.at(column); }
  // Names of `wanted` that are missing, joined; empty: all there.
  std::string MissingColumns(const std::vector<std::string>& wanted) const;

 private:
  std::map<std::string, std::vector<double>> columns_;
  std::size_t rows_ = 0;
};

}  // namespace omni::tools
