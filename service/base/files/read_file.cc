#include "service/base/files/read_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <cstring>

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

}  // namespace

Result<std::string> ReadFile(const std::string& path, std::size_t max_bytes) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (fd < 0) return CannotRead(path, errno);
  Result<std::string> result = ReadAll(fd, path, max_bytes);
  ::close(fd);
  return result;
}

}  // namespace omni::base
