// The race in a status, for people.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace omni::tools {

// "2 laps, last 9.84 s, best 9.61 s, now 3.20 s; 52 mm/s; 4 hits"; empty: no race is on.
std::string RaceText(const nlohmann::json& status);

}  // namespace omni::tools
