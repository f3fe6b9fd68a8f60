// Reads JSON that another version may have written: missing values and other types become "-" or a default.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace omni::tools {

// The value at a JSON pointer ("/tick/count") as text for people; numbers with `digits` after the point.
std::string TextAt(const nlohmann::json& document, const char* pointer, int digits = 0);

// The first line of output while omnid runs a simulation, with newline; otherwise empty.
std::string SimulationLine(const nlohmann::json& status);

// "name", or "name (a simulation)" if the device is one and its name does not say so; "-" if there is none.
std::string DeviceName(const nlohmann::json& status);

// NaN when missing or no number.
double NumberAt(const nlohmann::json& document, const char* pointer);

bool TrueAt(const nlohmann::json& document, const char* pointer);

// An array to walk over; empty when missing or no array.
const nlohmann::json& ArrayAt(const nlohmann::json& document, const char* pointer);

}  // namespace omni::tools
