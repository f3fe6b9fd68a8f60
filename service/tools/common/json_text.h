// JSON as text for people: missing values and other types become "-". Values themselves: base/files/json_values.h.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/base/files/json_values.h"

namespace omni::tools {

using base::ArrayAt;
using base::NumberAt;
using base::ParseJsonOrNull;
using base::TrueAt;

// The value at a JSON pointer ("/tick/count") as text for people; numbers with `digits` after the point.
std::string TextAt(const nlohmann::json& document, const char* pointer, int digits = 0);

// The first line of output while omnid runs a simulation, with newline; otherwise empty.
std::string SimulationLine(const nlohmann::json& status);

// "name", or "name (a simulation)" if the device is one and its name does not say so; "-" if there is none.
std::string DeviceName(const nlohmann::json& status);

}  // namespace omni::tools
