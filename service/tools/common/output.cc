#include "service/tools/common/output.h"

#include <cstdio>
#include <iostream>

#include <nlohmann/json.hpp>

#include "service/base/files/json_document.h"
#include "service/console/command.h"
#include "service/console/wrap.h"
#include "service/protocol/text.h"

namespace omni::tools {

void Print(const std::string& text) { std::cout << console::ForPeople(text); }

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

void WriteJson(std::ostream& out, const nlohmann::ordered_json& document) {
  out << document.dump(2, ' ', false, json::error_handler_t::replace) << "\n";
}

void PrintJson(const json& document) {
  std::cout << document.dump(2, ' ', false, json::error_handler_t::replace) << "\n";
}

void PrintJson(const nlohmann::ordered_json& document) { WriteJson(std::cout, document); }

int FailWith(bool as_json, const std::string& command, const std::string& error, int status) {
  if (as_json) PrintJson(json{{"error", error}});
  console::Fail(command, error);
  return status;
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
