// Files of subcommands: JSON that another program wrote, or an earlier run of ours, is checked against limits before it
// is parsed, so that it cannot exhaust the JSON library's parsers; a user's file is written completely or not at all.
#pragma once

#include <string>
#include <string_view>

#include "service/base/files/json_document.h"
#include "service/base/result.h"

namespace omni::tools {

// Manifests of OpenXR, reports of applications.
inline constexpr base::JsonLimits kManifestJson{.bytes = 1 << 20, .values = 5'000, .depth = 32};

// The text of a file that is JSON within the limits. The error names the path.
base::Result<std::string> ReadJsonFile(const std::string& path, const base::JsonLimits& limits);

// An existing file is replaced only with `overwrite`, else refused and left as it is. The error names the path, the
// reason and what to do.
base::Status WriteWholeFile(const std::string& path, std::string_view content, bool overwrite);

// Results that can be made again: in place, also to a pipe or /dev/stdout. Empty: written. Else "PATH: cannot be
// written (REASON); check the folder".
std::string WriteText(const std::string& path, const std::string& text);

}  // namespace omni::tools
