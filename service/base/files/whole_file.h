// Files that are read, replaced or begun with care for what may lie at a path.
//
// Atomic file replacement: writes a temporary file in the same folder, syncs it, renames it into place and syncs the
// folder. After a full disk, a kill or a power cut the path has either the old or the new content. Used for every file
// that a user would miss. Only for set-up and threads that may wait for a disk.
#pragma once

#include <sys/types.h>

#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "service/base/result.h"
#include "service/base/unique_fd.h"

namespace omni::base {

struct WholeFileOptions {
  bool replace = true;         // false: an existing file is kept, EEXIST
  bool make_folder = false;    // with its parents
  std::optional<mode_t> mode;  // exactly this; none: that of the replaced file, else as the umask allows
};

// Name of the temporary file: the path, this, and eight digits. Left behind only by a killed process.
inline constexpr std::string_view kUnfinishedMark = ".new-";

// A file beside the one that it is to become; removed on destruction unless it was placed.
class UnfinishedFile {
 public:
  explicit UnfinishedFile(const std::string& path, mode_t mode = 0666);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  int error() const { return error_; }  // errno; 0: it was made
  int fd() const { return fd_.get(); }  // for reading and writing
  // 0, or the errno. EEXIST: it may not replace what is there. The folder is not synced.
  int Place(const std::string& path, bool replace);
  UniqueFd Take() { return std::move(fd_); }  // after it was placed

 private:
  std::string name_;
  UniqueFd fd_;
  int error_ = 0;
  bool placed_ = false;
};

// 0, or the errno; EEXIST: the name is taken.
int MoveToFreeName(const std::string& from, const std::string& to);

// Only then does a name in the folder of `path` survive a power cut. Some file systems cannot sync folders; they write
// them at their own pace.
void SyncFolderOf(const std::string& path);

// At this place of an open file, all of it. 0, or the errno; ReadAt: EIO where the file ends before.
int WriteAt(int fd, std::uint64_t offset, const void* from, std::size_t size);
int ReadAt(int fd, std::uint64_t offset, void* to, std::size_t size);

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

// Reads files that may be anything, a pipe, a device, an endless file: a regular one of at most `max_bytes`; never
// blocks. The error names the path and what to do.
Result<std::string> ReadFile(const std::string& path, std::size_t max_bytes);

// Files that are written as a recording goes on: never over an existing one, and never through a link, so that a name
// typed twice, or a link planted where a recording is expected, costs no file.

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
