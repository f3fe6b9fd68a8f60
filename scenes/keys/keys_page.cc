#include "scenes/keys/keys_page.h"

#include <algorithm>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/base/material.h"
#include "service/scene/tags/haptic_keys.h"

namespace omni::scenes {
namespace {

using Json = nlohmann::ordered_json;

// One row of any of the tables.
struct KeyRow {
  std::string key, unit, about;
  double minimum = 0, maximum = 0, standard = 0;
  bool whole = false;
};

template <class Fields>
std::vector<KeyRow> RowsOf(const Fields& fields) {
  std::vector<KeyRow> rows;
  for (const auto& f : fields) {
    rows.push_back({std::string(f.key), std::string(f.unit), std::string(f.about), f.minimum, f.maximum, f.Default(),
                    f.member.whole});
  }
  return rows;
}

// A table of the page (found by the line above it) and the place of the same keys in the schema.
struct KeyTable {
  std::string heading;  // begins the table's header line, or a line of text above it
  std::string schema;   // JSON pointer to the properties
  std::vector<KeyRow> rows;
};

std::vector<KeyTable> KeyTables() {
  return {{"## Keys of a material", "/properties", RowsOf(base::kMaterialFields)},
          {"Further keys with `\"role\": \"joystick\"`", "/$defs/joystick/properties", RowsOf(scene::kJoystickKeys)},
          {"and with `\"role\": \"vehicle\"`", "/$defs/vehicle/properties", RowsOf(scene::kVehicleKeys)},
          {"A node with `\"role\": \"checkpoint\"`", "/$defs/checkpoint/properties", RowsOf(scene::kCheckpointKeys)}};
}

std::string Text(double value) {
  std::ostringstream text;
  text << value;
  return text.str();
}

std::vector<std::string> LinesOf(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

std::string KeyIn(const std::string& line) {
  const std::size_t end = line.starts_with("| `") ? line.find('`', 3) : std::string::npos;
  return end == std::string::npos ? std::string() : line.substr(3, end - 3);
}

// "| `damping` | N*s/m | 0 .. 5 | 0 | while pressed in |"
std::string RowText(const KeyRow& row, bool with_meaning) {
  std::string text = "| `" + row.key + "` | " + row.unit + " | " + Text(row.minimum) + " .. " + Text(row.maximum) +
                     " | " + Text(row.standard) + " |";
  if (with_meaning) text += row.about.empty() ? " |" : " " + row.about + " |";
  return text;
}

// A row of words ("constant, linear, smooth") has no range.
bool IsOfNumbers(const std::string& line) { return line.find(" .. ") != std::string::npos; }

// Rows of numbers are written again, in the order of the table; a row of words keeps its place behind its number.
std::vector<std::string> NewRows(const std::vector<std::string>& old, const KeyTable& table, bool with_meaning) {
  std::vector<std::string> rows;
  const auto words_behind = [&](const std::string& key) {
    bool behind = key.empty();
    for (const std::string& line : old) {
      if (IsOfNumbers(line)) behind = KeyIn(line) == key;
      if (behind && !IsOfNumbers(line)) rows.push_back(line);
    }
  };
  words_behind("");
  for (const KeyRow& row : table.rows) {
    rows.push_back(RowText(row, with_meaning));
    words_behind(row.key);
  }
  return rows;
}

void UpdateTable(std::vector<std::string>& lines, const KeyTable& table) {
  const auto heading = std::find_if(lines.begin(), lines.end(),
                                    [&](const std::string& line) { return line.starts_with(table.heading); });
  const auto header =
      std::find_if(heading, lines.end(), [](const std::string& line) { return line.starts_with("| key |"); });
  if (header == lines.end()) throw std::runtime_error("no table of keys below \"" + table.heading + "\"");
  const bool with_meaning = header->find("meaning") != std::string::npos;
  const auto first = header + 2;
  const auto end = std::find_if(first, lines.end(), [](const std::string& line) { return !line.starts_with("|"); });
  const std::vector<std::string> rows = NewRows({first, end}, table, with_meaning);
  lines.insert(lines.erase(first, end), rows.begin(), rows.end());
}

// The object of properties that holds "softness.thickness", and the last part of the key.
Json& PropertiesOf(Json& properties, const std::string& key, std::string& name) {
  const std::size_t dot = key.find('.');
  name = key.substr(0, dot);
  if (dot == std::string::npos) return properties;
  Json& group = properties[name];
  Json& object = group.contains("oneOf") ? group["oneOf"].back() : group;
  if (!object.contains("type")) object["type"] = "object";
  return PropertiesOf(object["properties"], key.substr(dot + 1), name);
}

Json PropertyOf(const KeyRow& row) {
  Json property = {{"type", row.whole ? "integer" : "number"}};
  const auto number = [](double value) {
    return value == static_cast<std::int64_t>(value) ? Json(static_cast<std::int64_t>(value)) : Json(value);
  };
  property["minimum"] = number(row.minimum);
  property["maximum"] = number(row.maximum);
  property["default"] = number(row.standard);
  std::string about = row.about;
  about.erase(std::remove(about.begin(), about.end(), '`'), about.end());
  const std::string unit = row.unit == "1" ? "" : row.unit;
  const std::string text = unit + (unit.empty() || about.empty() ? "" : "; ") + about;
  if (!text.empty()) property["description"] = text;
  return property;
}

bool IsNumber(const Json& property) {
  return property.is_object() && property.contains("maximum") && property.contains("default");
}

// Takes away the numbers that no row is of.
void Prune(Json& properties, const std::string& prefix, const std::vector<KeyRow>& rows) {
  std::vector<std::string> gone;
  for (auto& [name, property] : properties.items()) {
    const std::string key = prefix + name;
    if (IsNumber(property)) {
      if (std::none_of(rows.begin(), rows.end(), [&](const KeyRow& row) { return row.key == key; }))
        gone.push_back(name);
      continue;
    }
    Json* object = property.contains("oneOf") ? &property["oneOf"].back() : &property;
    if (object->contains("properties")) Prune((*object)["properties"], key + ".", rows);
  }
  for (const std::string& name : gone) properties.erase(name);
}

// Stands on a line of its own: holds no properties, however deep.
bool IsFlat(const Json& json) {
  return !json.contains("properties") &&
         std::all_of(json.begin(), json.end(), [](const Json& part) { return !part.is_structured() || IsFlat(part); });
}

std::string OnOneLine(const Json& json) {
  if (json.is_object()) {
    std::string text = "{";
    for (const auto& [name, part] : json.items())
      text += (text.size() > 1 ? ", " : "") + Json(name).dump() + ": " + OnOneLine(part);
    return text + "}";
  }
  if (!json.is_array()) return json.dump();
  std::string text = "[";
  for (const Json& part : json) text += (text.size() > 1 ? ", " : "") + OnOneLine(part);
  return text + "]";
}

// One line per property.
std::string Format(const Json& json, const std::string& indent, const std::string& name) {
  if (!json.is_structured() || (name != "properties" && IsFlat(json))) return OnOneLine(json);
  const std::string inner = indent + "  ";
  std::string text;
  for (const auto& [key, part] : json.items()) {
    text += (text.empty() ? "" : ",\n") + inner + (json.is_object() ? Json(key).dump() + ": " : "") +
            Format(part, inner, key);
  }
  return (json.is_object() ? "{\n" : "[\n") + text + "\n" + indent + (json.is_object() ? "}" : "]");
}

}  // namespace

std::string UpdatedPage(const std::string& page) {
  std::vector<std::string> lines = LinesOf(page);
  for (const KeyTable& table : KeyTables()) UpdateTable(lines, table);
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

std::string UpdatedSchema(const std::string& schema) {
  Json root = Json::parse(schema);
  for (const KeyTable& table : KeyTables()) {
    Json& properties = root.at(Json::json_pointer(table.schema));
    Prune(properties, "", table.rows);
    for (const KeyRow& row : table.rows) {
      std::string name;
      Json& place = PropertiesOf(properties, row.key, name);
      place[name] = PropertyOf(row);
    }
  }
  return Format(root, "", "") + "\n";
}

}  // namespace omni::scenes
