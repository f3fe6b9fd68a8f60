// Pictures of omni-bench layer and omni-bench align.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "service/base/result.h"

namespace omni::bench {

// `document` as bench_plot.h has it; `file` names it in errors. An SVG.
base::Result<std::string> DrawLayer(const nlohmann::json& document, const std::string& file);
base::Result<std::string> DrawAlign(const nlohmann::json& document, const std::string& file);

}  // namespace omni::bench
