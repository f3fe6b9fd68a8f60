// JSON that another program wrote, or an earlier run of ours: checked against limits before it is parsed, so that it
// cannot exhaust the JSON library's parsers.
#pragma once

#include <string>

#include "service/base/files/json_document.h"

namespace omni::tools {

// Manifests of OpenXR, reports of applications.
inline constexpr base::JsonLimits kManifestJson{.bytes = 1 << 20, .values = 5'000, .depth = 32};
// Status of omnid.
inline constexpr base::JsonLimits kStatusJson{.bytes = 1 << 20, .values = 20'000, .depth = 32};

// The text of a file that is JSON within the limits. The error names the path.
base::Result<std::string> ReadJsonFile(const std::string& path, const base::JsonLimits& limits);

}  // namespace omni::tools
