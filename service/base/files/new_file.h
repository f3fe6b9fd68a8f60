// Files that are written as a recording goes on: never over an existing one, and never through a link, so that a name
// typed twice, or a link planted where a recording is expected, costs no file.
#pragma once

#include <string>

#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::base {

// A new file of mode 0644 under the umask, for writing. What is no file (a device, a pipe) is opened as it is. Error:
// it exists already (a link counts), or it cannot be made; with what to do.
Result<UniqueFd> MakeNewFile(const std::string& path);

// Why MakeNewFile would fail; empty: it would not. `replace`: after RemoveForNew.
std::string NewFileProblem(const std::string& path, bool replace);

// What the person has agreed to: removes an existing file, or a link itself. Nothing there is fine.
Status RemoveForNew(const std::string& path);

// `path`, or if there is something already, the first of path.2, path.3, ... that is free.
std::string FreeName(const std::string& path);

}  // namespace omni::base
