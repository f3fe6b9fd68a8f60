#include "service/tools/common/json_text.h"

#include <cstdio>

#include <nlohmann/json.hpp>

#include "service/base/files/json_values.h"
#include "service/protocol/text.h"

namespace omni::tools {
using nlohmann::json;

std::string TextAt(const json& document, const char* pointer, int digits) {
  const json* value = base::ValueAt(document, pointer);
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

}  // namespace omni::tools
