// omni scene edits, undo, redo, save: what was sculpted in a running service.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

namespace omni::tools {

// A line for the scene, one for each object.
std::string EditsText(const nlohmann::json& edits);

}  // namespace omni::tools
