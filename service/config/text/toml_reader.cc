#include "service/config/text/toml_reader.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <sstream>

#include "service/base/files/nearest_word.h"
#include "service/config/text/text_file.h"

namespace omni::config {
namespace {

std::string Shortest(double value) {
  char text[32];
  std::snprintf(text, sizeof(text), "%.9g", value);
  return text;
}

std::string Between(Range range) { return "[" + Shortest(range.low) + ", " + Shortest(range.high) + "]"; }

std::string KindOf(const toml::node& node) {
  std::ostringstream text;
  text << node.type();
  return text.str();
}

// Contents of files end up in terminals and logs: no control characters, and a limited length.
std::string Printable(std::string text) {
  constexpr std::size_t kMost = 500;
  if (text.size() > kMost) text = text.substr(0, kMost) + "...";
  for (char& c : text) {
    const auto byte = static_cast<unsigned char>(c);
    if (byte < 0x20 || byte == 0x7F) c = '?';
  }
  return text;
}

std::string Shortened(std::string_view text) {
  constexpr std::size_t kMost = 60;
  return text.size() <= kMost ? std::string(text) : std::string(text.substr(0, kMost)) + "...";
}

std::string Listed(std::span<const std::string_view> words) {
  std::string list;
  for (const std::string_view word : words) list += (list.empty() ? "\"" : ", \"") + std::string(word) + "\"";
  return list;
}

}  // namespace

std::string TomlFloat(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.17g", value);
  std::string number(text);
  if (number.find_first_of(".en") == std::string::npos) number += ".0";
  return number;
}

std::string TomlText(const std::string& text) {
  std::string quoted = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') quoted += '\\';
    quoted += c;
  }
  return quoted + "\"";
}

base::Result<toml::table> ParseToml(const std::string& text, const std::string& file) {
  if (const base::Status checked = CheckToml(text, file); !checked.ok()) return base::Error{checked.error()};
  try {
    return toml::parse(text, file);
  } catch (const toml::parse_error& error) {
    return base::Error{file + ":" + std::to_string(error.source().begin.line) + ": " +
                       Printable(std::string(error.description())) + "; correct the TOML syntax there"};
  }
}

void FileProblem::Report(const toml::node* where, const std::string& what) {
  if (!message_.empty()) return;
  const bool placed = where != nullptr && where->source().begin.line > 0;
  message_ =
      file_ + (placed ? ":" + std::to_string(where->source().begin.line) : std::string()) + ": " + Printable(what);
}

const toml::node* TableReader::Find(const char* key) {
  known_.emplace_back(key);
  return table_.get(key);
}

const toml::node* TableReader::Require(const char* key, const std::string& expected) {
  const toml::node* node = Find(key);
  if (node == nullptr) problem_.Report(&table_, NameOf(key) + " is missing; add " + expected);
  return node;
}

double TableReader::CheckedNumber(const toml::node& node, const std::string& name, Range range) {
  if (!node.is_number()) {
    problem_.Report(&node, name + " is a " + KindOf(node) + "; must be a number in " + Between(range));
    return range.low;
  }
  const double value = node.value<double>().value_or(std::nan(""));
  if (!(value >= range.low && value <= range.high)) {
    problem_.Report(&node, name + " = " + Shortest(value) + " is out of range; must be in " + Between(range));
    return range.low;
  }
  return value;
}

double TableReader::Number(const char* key, Range range, std::optional<double> fallback) {
  const toml::node* node = fallback ? Find(key) : Require(key, "a number in " + Between(range));
  if (node == nullptr) return fallback.value_or(range.low);
  return CheckedNumber(*node, NameOf(key), range);
}

int TableReader::Integer(const char* key, Range range) {
  const toml::node* node = Require(key, "an integer in " + Between(range));
  if (node != nullptr && !node->is_integer()) {
    problem_.Report(node, NameOf(key) + " is a " + KindOf(*node) + "; must be an integer in " + Between(range));
    return static_cast<int>(range.low);
  }
  return static_cast<int>(node == nullptr ? range.low : CheckedNumber(*node, NameOf(key), range));
}

std::string TableReader::Text(const char* key, std::size_t max_bytes) {
  const std::string expected = "a text of 1 to " + std::to_string(max_bytes) + " bytes";
  const toml::node* node = Require(key, expected);
  if (node == nullptr) return {};
  const auto text = node->value_exact<std::string>();
  if (!text) {
    problem_.Report(node, NameOf(key) + " is a " + KindOf(*node) + "; must be " + expected);
    return {};
  }
  const bool printable = std::none_of(text->begin(), text->end(), [](char c) {
    return static_cast<unsigned char>(c) < 0x20 || static_cast<unsigned char>(c) == 0x7F;
  });
  if (!(!text->empty() && text->size() <= max_bytes && printable)) {
    problem_.Report(node, NameOf(key) + " = \"" + Shortened(*text) + "\" has " + std::to_string(text->size()) +
                              " bytes" + (printable ? "" : " and control characters") + "; must be " + expected);
    return {};
  }
  return *text;
}

std::string TableReader::Choice(const char* key, std::span<const std::string_view> allowed, std::string_view fallback) {
  const toml::node* node = Find(key);
  if (node == nullptr) return std::string(fallback);
  const auto text = node->value_exact<std::string>();
  if (text && std::find(allowed.begin(), allowed.end(), *text) != allowed.end()) return *text;
  problem_.Report(node, NameOf(key) + (text ? " = \"" + Shortened(*text) + "\"" : " is a " + KindOf(*node)) +
                            "; must be one of " + Listed(allowed) +
                            (text ? base::DidYouMean(*text, allowed) : std::string()));
  return std::string(fallback);
}

void TableReader::Numbers(const char* key, Range range, std::span<double> values) {
  std::fill(values.begin(), values.end(), range.low);
  const std::string expected = "an array of " + std::to_string(values.size()) + " numbers in " + Between(range);
  const toml::node* node = Require(key, expected);
  if (node == nullptr) return;
  const toml::array* array = node->as_array();
  if (array == nullptr || array->size() != values.size()) {
    problem_.Report(node, NameOf(key) + " is a " + KindOf(*node) +
                              (array != nullptr ? " of " + std::to_string(array->size()) : std::string()) +
                              "; must be " + expected);
    return;
  }
  for (std::size_t i = 0; i < values.size(); ++i) {
    values[i] = CheckedNumber(*array->get(i), NameOf(key) + "[" + std::to_string(i) + "]", range);
  }
}

base::Vec3 TableReader::Vector(const char* key, Range range, std::optional<base::Vec3> fallback) {
  if (fallback && table_.get(key) == nullptr) {
    known_.emplace_back(key);
    return *fallback;
  }
  double values[3];
  Numbers(key, range, values);
  return {values[0], values[1], values[2]};
}

bool TableReader::Boolean(const char* key, bool fallback) {
  const toml::node* node = Find(key);
  if (node == nullptr) return fallback;
  if (!node->is_boolean()) {
    problem_.Report(node, NameOf(key) + " is a " + KindOf(*node) + "; must be true or false");
  }
  return node->value_exact<bool>().value_or(fallback);
}

std::optional<std::vector<std::string>> TableReader::Texts(const char* key, std::size_t most, std::size_t max_bytes) {
  const toml::node* node = Find(key);
  if (node == nullptr) return std::nullopt;
  const std::string expected =
      "an array of at most " + std::to_string(most) + " texts of 1 to " + std::to_string(max_bytes) + " bytes";
  const toml::array* array = node->as_array();
  if (array == nullptr || array->size() > most) {
    problem_.Report(node, NameOf(key) + " is a " + KindOf(*node) +
                              (array != nullptr ? " of " + std::to_string(array->size()) : std::string()) +
                              "; must be " + expected);
    return std::nullopt;
  }
  std::vector<std::string> texts;
  for (const toml::node& element : *array) {
    auto text = element.value_exact<std::string>();
    if (!text || text->empty() || text->size() > max_bytes) {
      problem_.Report(&element, NameOf(key) + "[" + std::to_string(texts.size()) + "] is a " + KindOf(element) +
                                    (text ? " of " + std::to_string(text->size()) + " bytes" : std::string()) +
                                    "; must be " + expected);
      return std::nullopt;
    }
    texts.push_back(std::move(*text));
  }
  return texts;
}

const toml::table* TableReader::Table(const char* key) {
  const toml::node* node = Require(key, std::string("a table [") + key + "]");
  if (node == nullptr) return nullptr;
  if (!node->is_table()) {
    problem_.Report(node, NameOf(key) + " is a " + KindOf(*node) + "; must be a table [" + key + "]");
  }
  return node->as_table();
}

std::vector<const toml::table*> TableReader::Tables(const char* key, std::size_t least, std::size_t most) {
  const std::string count =
      least == most ? std::to_string(least) : std::to_string(least) + " to " + std::to_string(most);
  const std::string expected = count + " tables [[" + key + "]]";
  const toml::node* node = Require(key, expected);
  if (node == nullptr) return {};
  const toml::array* array = node->as_array();
  const bool all_tables =
      array != nullptr && std::all_of(array->begin(), array->end(), [](const toml::node& n) { return n.is_table(); });
  if (!all_tables || !(array->size() >= least && array->size() <= most)) {
    problem_.Report(
        node, NameOf(key) +
                  (all_tables ? " has " + std::to_string(array->size()) + " tables" : " is not an array of tables") +
                  "; must be " + expected);
    return {};
  }
  std::vector<const toml::table*> tables;
  for (const toml::node& element : *array) tables.push_back(element.as_table());
  return tables;
}

void TableReader::ReportUnknownKeys() {
  for (const auto& [key, node] : table_) {
    if (std::find(known_.begin(), known_.end(), key.str()) != known_.end()) continue;
    std::string allowed;
    for (const std::string& known : known_) allowed += (allowed.empty() ? "" : ", ") + known;
    problem_.Report(&node, NameOf(Shortened(key.str()).c_str()) + " is unknown; allowed here: " + allowed +
                               base::DidYouMean(key.str(), known_));
  }
}

}  // namespace omni::config
