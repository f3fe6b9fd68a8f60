// The service's status for people.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace omni::tools {

// Missing keys show as "-": the service may be of another version.
std::string StatusText(const nlohmann::json& status);

}  // namespace omni::tools
