// Reads files that may be anything: a pipe, a device, an endless file.
#pragma once

#include <cstddef>
#include <string>

#include "service/base/result.h"

namespace omni::base {

// A regular file of at most `max_bytes`; never blocks. The error names the path and what to do.
Result<std::string> ReadFile(const std::string& path, std::size_t max_bytes);

}  // namespace omni::base
