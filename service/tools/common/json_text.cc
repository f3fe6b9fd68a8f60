#include "service/tools/common/json_text.h"

#include <cmath>
#include <cstdio>
#include <limits>

#include <nlohmann/json.hpp>

#include "service/protocol/text.h"

namespace omni::tools {
namespace {

using nlohmann::json;

const json* Find(const json& document, const char* pointer) {
  const json::json_pointer at(pointer);
  return document.contains(at) ? &document.at(at) : nullptr;
}

}  // namespace

std::string TextAt(const json& document, const char* pointer, int digits) {
  const json* value = Find(document, pointer);
  if (value == nullptr) return "-";
  if (value->is_string()) return protocol::Printable(value->get_ref<const std::string&>());
  if (value->is_boolean()) return value->get<bool>() ? "yes" : "no";
  if (value->is_number_integer() && digits == 0) return value->dump();
  if (!value->is_number()) return "-";
  char text[64];
  std::snprintf(text, sizeof(text), "%.*f", digits, value->get<double>());
  return text;
}

std::string SimulationLine(const json& status) {
  return status.contains("SIMULATION") ? "SIMULATION: " + TextAt(status, "/SIMULATION") + "\n" : std::string();
}

std::string DeviceName(const json& status) {
  const std::string name = TextAt(status, "/device/name");
  const bool said = name == "-" || name.find("simulation") != std::string::npos;
  return !said && TrueAt(status, "/device/simulation") ? name + " (a simulation)" : name;
}

double NumberAt(const json& document, const char* pointer) {
  const json* value = Find(document, pointer);
  return value != nullptr && value->is_number() ? value->get<double>() : std::numeric_limits<double>::quiet_NaN();
}

bool TrueAt(const json& document, const char* pointer) {
  const json* value = Find(document, pointer);
  return value != nullptr && value->is_boolean() && value->get<bool>();
}

const json& ArrayAt(const json& document, const char* pointer) {
  static const json empty = json::array();
  const json* value = Find(document, pointer);
  return value != nullptr && value->is_array() ? *value : empty;
}

}  // namespace omni::tools
