// Writes a file completely or not at all (service/base/files/whole_file.h).
#pragma once

#include <string>
#include <string_view>

#include "service/base/result.h"

namespace omni::tools {

// An existing file is replaced only with `overwrite`, else refused and left as it is. The error names the path, the
// reason and what to do.
base::Status WriteWholeFile(const std::string& path, std::string_view content, bool overwrite);

}  // namespace omni::tools
