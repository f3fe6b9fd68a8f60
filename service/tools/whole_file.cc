#include "service/tools/whole_file.h"

#include <fcntl.h>
#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <filesystem>
#include <system_error>

#include "service/protocol/unique_fd.h"

namespace omni::tools {
namespace {

std::string ReasonOf(int error) { return std::error_code(error, std::generic_category()).message(); }

bool WriteAllOf(int file, std::string_view content) {
  while (!content.empty()) {
    const ssize_t done = ::write(file, content.data(), content.size());
    if (done < 0 && errno == EINTR) continue;
    if (done <= 0) return false;
    content.remove_prefix(static_cast<std::size_t>(done));
  }
  return true;
}

// What a new file's mode would be.
mode_t NewFileMode() {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0666 & ~mask;
}

// False, with errno: not put there.
bool PutInPlace(const std::string& from, const std::string& to, bool overwrite) {
  if (overwrite) return ::rename(from.c_str(), to.c_str()) == 0;
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return true;
  if (errno != EINVAL && errno != ENOSYS) return false;
  // A file system without that flag: a second name is refused where there is one already.
  if (::link(from.c_str(), to.c_str()) != 0) return false;
  ::unlink(from.c_str());
  return true;
}

// All of `content` in a new file beside `path`, synced. 0, or the errno; without `name` it could not even be made.
int WriteBeside(const std::string& path, std::string_view content, mode_t mode, std::string& name) {
  std::string unfinished = path + ".XXXXXX";
  const protocol::UniqueFd file(::mkostemp(unfinished.data(), O_CLOEXEC));
  if (!file) return errno;
  name = unfinished;
  if (WriteAllOf(file.get(), content) && ::fchmod(file.get(), mode) == 0 && ::fsync(file.get()) == 0) return 0;
  const int error = errno;
  ::unlink(unfinished.c_str());
  return error;
}

}  // namespace

int ReplaceWholeFile(const std::string& path, std::string_view content, mode_t mode) {
  std::string fresh;
  if (const int error = WriteBeside(path, content, mode, fresh); error != 0) return error;
  if (PutInPlace(fresh, path, true)) return 0;
  const int error = errno;
  ::unlink(fresh.c_str());
  return error;
}

base::Status WriteWholeFile(const std::string& path, std::string_view content, bool overwrite) {
  std::error_code ignored;
  const base::Error exists{path + ": is there already; take another name, or --force to replace it"};
  if (std::filesystem::is_directory(path, ignored)) return base::Error{path + ": is a folder; give a file's name"};
  if (!overwrite && std::filesystem::exists(std::filesystem::symlink_status(path, ignored))) return exists;
  std::string fresh;
  int error = WriteBeside(path, content, NewFileMode(), fresh);
  if (error == 0) {
    if (PutInPlace(fresh, path, overwrite)) return base::Ok{};
    error = errno;
    ::unlink(fresh.c_str());
    if (error == EEXIST) return exists;
  }
  if (fresh.empty()) return base::Error{path + ": cannot be made here: " + ReasonOf(error) + "; choose another folder"};
  return base::Error{path + ": cannot be written: " + ReasonOf(error) + "; is there space?"};
}

}  // namespace omni::tools
