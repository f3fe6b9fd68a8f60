#include "service/base/files/json_values.h"

#include <limits>

#include <nlohmann/json.hpp>

#include "service/base/files/json_document.h"

namespace omni::base {

using nlohmann::json;

json ParseJsonOrNull(const std::string& text) {
  return CheckJson(text, JsonLimits{}).ok() ? json::parse(text) : json();
}

const json* ValueAt(const json& document, const char* pointer) {
  const json::json_pointer at(pointer);
  return document.contains(at) ? &document.at(at) : nullptr;
}

double NumberAt(const json& document, const char* pointer) {
  const json* value = ValueAt(document, pointer);
  return value != nullptr && value->is_number() ? value->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

bool TrueAt(const json& document, const char* pointer) {
  const json* value = ValueAt(document, pointer);
  return value != nullptr && value->is_boolean() && value->get<bool>();
}

std::string StringAt(const json& document, const char* pointer) {
  const json* value = ValueAt(document, pointer);
  return value != nullptr && value->is_string() ? value->get<std::string>() : std::string();
}

const json& ArrayAt(const json& document, const char* pointer) {
  static const json empty = json::array();
  const json* value = ValueAt(document, pointer);
  return value != nullptr && value->is_array() ? *value : empty;
}

}  // namespace omni::base
