// Run time against error, as pictures made from the JSON files of omni-bench.
#pragma once

#include <string>

#include <nlohmann/json.hpp>

#include "service/base/result.h"

namespace omni::bench {

// `document`: {"name", "commit", "machine", "rows"} of `omni-bench solver`, `tracking`, `stability`, `collision`,
// `deformable`, `layer` or `align`; `file` names it in messages. Rows that lack the keys of the picture are left out; a
// document without any usable row is an error.
base::Result<std::string> DrawBench(const nlohmann::json& document, const std::string& file);

}  // namespace omni::bench
