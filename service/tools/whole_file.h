// A file that appears whole or not at all.
#pragma once

#include <sys/types.h>

#include <string>
#include <string_view>

#include "service/base/result.h"

namespace omni::tools {

// Written beside, synced, then put in place in one step. An existing file is replaced only with `overwrite`, else
// refused and left as it is. The error names the path, the reason and what to do.
base::Status WriteWholeFile(const std::string& path, std::string_view content, bool overwrite);

// The same for a caller with words of its own: replaces what is there, with this mode whatever the umask is.
// 0, or the errno.
int ReplaceWholeFile(const std::string& path, std::string_view content, mode_t mode);

}  // namespace omni::tools
