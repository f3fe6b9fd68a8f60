// Atomic file replacement: writes a temporary file in the same folder, syncs it, renames it into place and syncs the
// folder. After a full disk, a kill or a power cut the path has either the old or the new content. Used for every file
// that a user would miss. Only for set-up and threads that may wait for a disk.
#pragma once

#include <sys/types.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "service/base/result.h"

namespace omni::base {

struct WholeFileOptions {
  bool replace = true;         // false: an existing file is kept, EEXIST
  bool make_folder = false;    // with its parents
  std::optional<mode_t> mode;  // exactly this; none: that of the replaced file, else as the umask allows
};

// Name of the temporary file: the path, this, and eight digits. Left behind only by a killed process.
inline constexpr std::string_view kUnfinishedMark = ".new-";

// The pieces of `content` one after another. A symbolic link at `path` is itself replaced by the file, and its target
// is never written: a planted link cannot choose which file is lost. Folders in the path may be links. Returns 0, or
// the errno; then `path` is unchanged and no temporary file is left. EINVAL: not a regular file.
int PutWholeFile(const std::string& path, std::initializer_list<std::string_view> content,
                 const WholeFileOptions& options = {});

// Whether a file could be written there now, tried with an empty temporary one. 0, or the errno.
int TryWholeFile(const std::string& path, const WholeFileOptions& options = {});

// "PATH: cannot be written: no space left on its disk; free some and try again"; every cause with its remedy.
std::string WriteProblem(const std::string& path, int error);

// So that it is still gone after a power cut. A link is removed itself, not its target; a path with nothing is fine.
Status RemoveWholeFile(const std::string& path);

Status WriteWholeFile(const std::string& path, std::string_view content, const WholeFileOptions& options = {});

}  // namespace omni::base
