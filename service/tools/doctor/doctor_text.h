// Findings of `omni doctor` as text and as JSON.
#pragma once

#include <string>
#include <vector>

#include "service/tools/doctor/diagnosis.h"

namespace omni::tools {

struct Diagnosed {
  std::string name;
  Finding finding;
};

// Every diagnosis once, in the table's order.
std::vector<Diagnosed> Diagnose(const Surroundings& surroundings);

// `status` is omnid's, null if it does not run: a simulation is reported first.
std::string DoctorText(const std::vector<Diagnosed>& findings, const nlohmann::json& status);
nlohmann::json DoctorJson(const std::vector<Diagnosed>& findings, const nlohmann::json& status);

bool AnyFailed(const std::vector<Diagnosed>& findings);

}  // namespace omni::tools
