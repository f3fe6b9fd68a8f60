#include "service/config/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "service/base/whole_file.h"

namespace omni::config {
namespace {

base::Error CannotRead(const std::string& path, int code) {
  return {path + ": cannot be read (" + std::strerror(code) + "); check the path and its permissions"};
}

base::Result<std::string> ReadAll(int fd, const std::string& path) {
  struct stat info {};
  if (::fstat(fd, &info) != 0) return CannotRead(path, errno);
  if (!S_ISREG(info.st_mode)) return base::Error{path + ": is not a regular file; name a .toml file"};
  // One byte more than allowed: a file that grows while it is read is noticed as well.
  std::string text(kMaxSettingsBytes + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t count = ::read(fd, text.data() + size, text.size() - size);
    if (count < 0 && errno == EINTR) continue;
    if (count < 0) return CannotRead(path, errno);
    if (count == 0) break;
    size += static_cast<std::size_t>(count);
  }
  if (size > kMaxSettingsBytes) {
    return base::Error{path + ": is longer than " + std::to_string(kMaxSettingsBytes) +
                       " bytes, which no settings file needs; check that this is the file you mean"};
  }
  text.resize(size);
  return text;
}

}  // namespace

base::Result<std::string> ReadTextFile(const std::string& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY);
  if (fd < 0) return CannotRead(path, errno);
  base::Result<std::string> result = ReadAll(fd, path);
  ::close(fd);
  return result;
}

base::Status WriteTextFile(const std::string& path, const std::string& text) {
  return base::WriteWholeFile(path, text, {.make_folder = true});
}

}  // namespace omni::config
