#include "service/base/files/whole_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <system_error>

namespace omni::base {
namespace {

Error CannotRead(const std::string& path, int code) {
  return {path + ": cannot be read (" + std::strerror(code) + "); check the path and its permissions"};
}

Result<std::string> ReadAll(int fd, const std::string& path, std::size_t max_bytes) {
  struct stat info {};
  if (::fstat(fd, &info) != 0) return CannotRead(path, errno);
  if (!S_ISREG(info.st_mode)) return Error{path + ": is not a regular file; name one"};
  // One byte more than it has: a file that grows while it is read is noticed as well.
  const auto stored = static_cast<std::uint64_t>(info.st_size);
  std::string text(static_cast<std::size_t>(std::min<std::uint64_t>(stored, max_bytes)) + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t count = ::read(fd, text.data() + size, text.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return CannotRead(path, errno);
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
    // Files of /proc and /sys report a size of zero.
    if (size == text.size() && size <= max_bytes) text.resize(std::min(2 * size, max_bytes + 1));
  }
  if (size > max_bytes) {
    return Error{path + ": is longer than " + std::to_string(max_bytes) +
                 " bytes, the limit; check that this is the file you mean"};
  }
  text.resize(size);
  return text;
}

namespace fs = std::filesystem;

constexpr std::uint32_t kNamesTried = 100;

std::string FolderOf(const std::string& path) {
  const std::string folder = fs::path(path).parent_path().string();
  return folder.empty() ? "." : folder;
}

int MakeFolder(const std::string& folder) {
  std::error_code ignored;
  if (fs::is_directory(folder, ignored)) return 0;
  const std::string above = FolderOf(folder);
  if (const int error = MakeFolder(above); error != 0) return error;
  if (::mkdir(folder.c_str(), 0777) != 0) return errno == EEXIST ? ENOTDIR : errno;
  SyncFolderOf(folder);
  return 0;
}

bool WriteAll(int fd, std::string_view content) {
  while (!content.empty()) {
    const ssize_t done = ::write(fd, content.data(), content.size());
    if (done < 0 && errno == EINTR) continue;
    if (done == 0) errno = EIO;
    if (done <= 0) return false;
    content.remove_prefix(static_cast<std::size_t>(done));
  }
  return true;
}

int Fill(int fd, std::initializer_list<std::string_view> content, std::optional<mode_t> mode) {
  for (const std::string_view piece : content) {
    if (!WriteAll(fd, piece)) return errno;
  }
  if (mode && ::fchmod(fd, *mode) != 0) return errno;
  return ::fsync(fd) == 0 ? 0 : errno;
}

// Checks what is at the path now: the mode that a new file inherits, or why it may not be written.
int CheckPlace(const std::string& path, bool replace, std::optional<mode_t>& mode) {
  struct stat there {};
  if (::lstat(path.c_str(), &there) != 0) return 0;  // nothing there; if it cannot be examined, opening reports why
  if (S_ISDIR(there.st_mode)) return EISDIR;
  if (!replace) return EEXIST;
  if (S_ISREG(there.st_mode) && !mode) mode = there.st_mode & 0777;
  // /dev/stdout is a link too and must remain one.
  struct stat end {};
  const bool ends_in_file = ::stat(path.c_str(), &end) != 0 || S_ISREG(end.st_mode);
  return ends_in_file ? 0 : EINVAL;
}

int Prepare(const std::string& path, const WholeFileOptions& options, std::optional<mode_t>& mode) {
  if (options.make_folder) {
    if (const int error = MakeFolder(FolderOf(path)); error != 0) return error;
  }
  return CheckPlace(path, options.replace, mode);
}

std::string CauseAndRemedy(const std::string& path, int error) {
  switch (error) {
    case ENOSPC:
      return "no space left on its disk; free some and try again";
    case EDQUOT:
      return "no space left in your quota; delete some of your files and try again";
    case EROFS:
      return "it is on a read-only file system; mount that for writing, or choose another folder";
    case EACCES:
    case EPERM:
      return "no permission; make the folder " + FolderOf(path) + " writable, or choose another one";
    case ENOENT:
    case ENOTDIR:
      return "there is no folder " + FolderOf(path) + "; create it, or choose another folder";
    case EISDIR:
      return "it is a folder; name a file";
    case EINVAL:
      return "it exists and is not a regular file; choose another name";
    case EEXIST:
      return "it already exists; choose another name, or move it away";
    case EFBIG:
      return "it exceeds the maximum file size; raise the limit (ulimit -f), or choose another disk";
    default:
      return std::error_code(error, std::generic_category()).message() + "; check the disk and the folder";
  }
}

}  // namespace

UnfinishedFile::UnfinishedFile(const std::string& path, mode_t mode) {
  std::uint32_t number = 0;
  [[maybe_unused]] const auto any = ::getrandom(&number, sizeof number, GRND_NONBLOCK);
  for (std::uint32_t i = 0; i < kNamesTried; ++i) {
    char digits[9];
    std::snprintf(digits, sizeof digits, "%08x", number + i);
    name_ = path + std::string(kUnfinishedMark) + digits;
    fd_.Reset(::open(name_.c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, mode));
    error_ = fd_ ? 0 : errno;
    if (error_ != EEXIST) break;
  }
}

UnfinishedFile::~UnfinishedFile() {
  if (error_ == 0 && !placed_) ::unlink(name_.c_str());
}

int UnfinishedFile::Place(const std::string& path, bool replace) {
  int error = 0;
  if (replace) {
    error = ::rename(name_.c_str(), path.c_str()) == 0 ? 0 : errno;
  } else {
    error = MoveToFreeName(name_, path);
  }
  placed_ = error == 0;
  return error;
}

int MoveToFreeName(const std::string& from, const std::string& to) {
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return errno;
  // For a file system without that flag: link() fails if the name already exists.
  if (::link(from.c_str(), to.c_str()) != 0) return errno;
  ::unlink(from.c_str());
  return 0;
}

void SyncFolderOf(const std::string& path) {
  const UniqueFd fd(::open(FolderOf(path).c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (fd) ::fsync(fd.get());
}

int WriteAt(int fd, std::uint64_t offset, const void* from, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t more =
        ::pwrite(fd, static_cast<const char*>(from) + done, size - done, static_cast<off_t>(offset + done));
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) return more == 0 ? EIO : errno;
    done += static_cast<std::size_t>(more);
  }
  return 0;
}

int ReadAt(int fd, std::uint64_t offset, void* to, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t more = ::pread(fd, static_cast<char*>(to) + done, size - done, static_cast<off_t>(offset + done));
    if (more < 0 && errno == EINTR) continue;
    if (more <= 0) return more == 0 ? EIO : errno;
    done += static_cast<std::size_t>(more);
  }
  return 0;
}

Result<std::string> ReadFile(const std::string& path, std::size_t max_bytes) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (fd < 0) return CannotRead(path, errno);
  Result<std::string> result = ReadAll(fd, path, max_bytes);
  ::close(fd);
  return result;
}

int PutWholeFile(const std::string& path, std::initializer_list<std::string_view> content,
                 const WholeFileOptions& options) {
  std::optional<mode_t> mode = options.mode;
  if (const int error = Prepare(path, options, mode); error != 0) return error;
  UnfinishedFile unfinished(path);
  if (unfinished.error() != 0) return unfinished.error();
  if (const int error = Fill(unfinished.fd(), content, mode); error != 0) return error;
  if (const int error = unfinished.Place(path, options.replace); error != 0) return error;
  SyncFolderOf(path);
  return 0;
}

int TryWholeFile(const std::string& path, const WholeFileOptions& options) {
  std::optional<mode_t> mode;
  if (const int error = Prepare(path, options, mode); error != 0) return error;
  return UnfinishedFile(path).error();
}

std::string WriteProblem(const std::string& path, int error) {
  return path + ": cannot be written: " + CauseAndRemedy(path, error);
}

Status RemoveWholeFile(const std::string& path) {
  if (::unlink(path.c_str()) != 0 && errno != ENOENT && errno != ENOTDIR) {
    return Error{path + ": cannot be removed: " + CauseAndRemedy(path, errno)};
  }
  SyncFolderOf(path);
  return Ok{};
}

Status WriteWholeFile(const std::string& path, std::string_view content, const WholeFileOptions& options) {
  const int error = PutWholeFile(path, {content}, options);
  if (error != 0) return Error{WriteProblem(path, error)};
  return Ok{};
}

}  // namespace omni::base
