// A file that is whole whatever happens: written beside its place, synced, put there in one step, its folder synced.
// After a full disk, a kill or a power cut the place holds the old content or the new one. Every file that a person
// would miss is written by this. Set-up and threads that may wait for a disk only.
#pragma once

#include <sys/types.h>

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>

#include "service/base/result.h"

namespace omni::base {

struct WholeFileOptions {
  bool replace = true;         // false: what is there already is left as it is, EEXIST
  bool make_folder = false;    // and those above it
  std::optional<mode_t> mode;  // exactly this; none: that of the file that is replaced, else what the umask leaves
};

// Name of the unfinished file: that of its place, this, and eight digits. Only a process that was killed leaves one.
inline constexpr std::string_view kUnfinishedMark = ".new-";

// The pieces of `content` one after another. A symbolic link at `path` is itself replaced by the file, and what it
// leads to is never written: a link that somebody else has put there cannot choose which file is lost. Folders on the
// way may be links. 0, or the errno; then `path` is as it was and nothing unfinished stays. EINVAL: no regular file is
// there.
int PutWholeFile(const std::string& path, std::initializer_list<std::string_view> content,
                 const WholeFileOptions& options = {});

// Whether a file could be put there now, tried with an empty one that goes again. 0, or the errno.
int TryWholeFile(const std::string& path, const WholeFileOptions& options = {});

// "PATH: cannot be written: no space left on its disk; free some and try again"; every cause with what to do.
std::string WriteProblem(const std::string& path, int error);

Status WriteWholeFile(const std::string& path, std::string_view content, const WholeFileOptions& options = {});

}  // namespace omni::base
