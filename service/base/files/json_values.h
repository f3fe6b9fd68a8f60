// Reads JSON that another program has sent, perhaps of another version: missing values and other types become a
// default.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace omni::base {

// Null when the text is no JSON, or exceeds the default JsonLimits.
nlohmann::json ParseJsonOrNull(const std::string& text);

// The value at a JSON pointer ("/tick/count"); null: it is missing.
const nlohmann::json* ValueAt(const nlohmann::json& document, const char* pointer);

// NaN when missing or no number.
double NumberAt(const nlohmann::json& document, const char* pointer);

bool TrueAt(const nlohmann::json& document, const char* pointer);

// A string as it was sent, not made printable; empty when missing or no string.
std::string StringAt(const nlohmann::json& document, const char* pointer);

// An array to walk over; empty when missing or no array.
const nlohmann::json& ArrayAt(const nlohmann::json& document, const char* pointer);

}  // namespace omni::base
