// Reads one TOML table key by key, with ranges. The first problem of a file is kept, with file, line, key, value and
// range; after it everything reads as its lowest allowed value, so that callers check once, at the end.
// Private to this folder, because it exposes toml++.
#pragma once

#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <toml++/toml.h>

#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::config {

// Within the limits of text_file.h. Used by every reader of TOML.
base::Result<toml::table> ParseToml(const std::string& text, const std::string& file);

// Text that reads back as the same number, and as a float even if it is whole.
std::string TomlFloat(double value);
// A basic string, quoted. Precondition: no control characters.
std::string TomlText(const std::string& text);

struct Range {
  double low;
  double high;
};

// What is wrong with one file.
class FileProblem {
 public:
  explicit FileProblem(std::string file) : file_(std::move(file)) {}
  // Keeps the first; later ones may only follow from it.
  void Report(const toml::node* where, const std::string& what);
  bool ok() const { return message_.empty(); }
  const std::string& message() const { return message_; }

 private:
  std::string file_;
  std::string message_;
};

class TableReader {
 public:
  // `path` names the table in messages: "" or "magnet" or "sensors[2]".
  TableReader(FileProblem& problem, const toml::table& table, std::string path)
      : problem_(problem), table_(table), path_(std::move(path)) {}

  // Without a fallback the key is required.
  double Number(const char* key, Range range, std::optional<double> fallback = {});
  int Integer(const char* key, Range range);
  std::string Text(const char* key, std::size_t max_bytes);
  std::string Choice(const char* key, std::span<const std::string_view> allowed, std::string_view fallback);
  void Numbers(const char* key, Range range, std::span<double> values);  // required
  base::Vec3 Vector(const char* key, Range range, std::optional<base::Vec3> fallback = {});

  bool Boolean(const char* key, bool fallback);
  // An array of texts, each of 1 to max_bytes bytes; empty when absent, and a problem when it is something else.
  std::optional<std::vector<std::string>> Texts(const char* key, std::size_t most, std::size_t max_bytes);

  // Null, and a problem, when absent or no table.
  const toml::table* Table(const char* key);
  // [[key]] tables; empty, and a problem, unless there are between `least` and `most`.
  std::vector<const toml::table*> Tables(const char* key, std::size_t least, std::size_t most);

  // Optional keys that this reader does not read.
  void AllowKeys(std::initializer_list<const char*> keys) { known_.insert(known_.end(), keys.begin(), keys.end()); }
  // Reports keys that were not read: a misspelt optional key must not be ignored.
  void ReportUnknownKeys();

  std::string NameOf(const char* key) const { return path_.empty() ? key : path_ + "." + key; }
  const toml::table& table() const { return table_; }

 private:
  const toml::node* Find(const char* key);
  const toml::node* Require(const char* key, const std::string& expected);
  double CheckedNumber(const toml::node& node, const std::string& name, Range range);

  FileProblem& problem_;
  const toml::table& table_;
  std::string path_;
  std::vector<std::string> known_;
};

}  // namespace omni::config
