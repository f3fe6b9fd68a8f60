#include "service/scene/gltf/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <span>
#include <system_error>

#include "service/base/unique_fd.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

std::string ReasonOf(int error) { return std::error_code(error, std::generic_category()).message(); }

}  // namespace

FileBytes::~FileBytes() {
  if (descriptor_ >= 0) close(descriptor_);
}

int OpenForReading(const std::string& path) {
  // O_NONBLOCK: opening a FIFO must not wait for its other end; it is refused by FileBytes.
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0)
    throw LoadError("", "cannot be opened (" + ReasonOf(errno) + "); check the path and its permissions");
  return descriptor;
}

void FileBytes::Open(const std::string& path, std::uint64_t max_bytes) {
  TakeDescriptor(OpenForReading(path), max_bytes);
}

void FileBytes::OpenDescriptor(int descriptor, std::uint64_t max_bytes) {
  const int copy = fcntl(descriptor, F_DUPFD_CLOEXEC, 3);
  if (copy < 0) throw LoadError("", "cannot be opened (" + ReasonOf(errno) + ")");
  TakeDescriptor(copy, max_bytes);
}

void FileBytes::TakeDescriptor(int descriptor, std::uint64_t max_bytes) {
  descriptor_ = descriptor;
  Examine(max_bytes);
}

void FileBytes::Examine(std::uint64_t max_bytes) {
  struct stat status {};
  if (fstat(descriptor_, &status) != 0) throw LoadError("", "cannot be examined (" + ReasonOf(errno) + ")");
  if (!S_ISREG(status.st_mode)) throw LoadError("", "is not a regular file; name a .glb or .gltf file");
  size_ = static_cast<std::uint64_t>(status.st_size);
  if (size_ > max_bytes) {
    throw LoadError("", "has " + std::to_string(size_) + " bytes, the limit is " + std::to_string(max_bytes) +
                            "; simplify the model or leave out what is not touched");
  }
}

void FileBytes::Read(std::uint64_t offset, void* to, std::size_t count) {
  if (!(offset <= size_ && count <= size_ - offset)) {
    throw LoadError("", "ends at byte " + std::to_string(size_) + ", but " + std::to_string(count) + " bytes at " +
                            std::to_string(offset) + " are needed; the file is truncated, copy or export it again");
  }
  auto* out = static_cast<std::byte*>(to);
  constexpr std::size_t kChunk = 1 << 20;
  while (count > 0) {
    const ssize_t got = pread(descriptor_, out, std::min(count, kChunk), static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw LoadError("", "cannot be read (" + ReasonOf(errno) + ")");
    if (got == 0) throw LoadError("", "became shorter while it was read; wait until it is written, then load it again");
    if (digest_) digest_->Add({out, static_cast<std::size_t>(got)});
    if (watch_) watch_->Did(static_cast<std::uint64_t>(got) / 1024);
    out += got;
    offset += static_cast<std::uint64_t>(got);
    count -= static_cast<std::size_t>(got);
    bytes_read_ += static_cast<std::uint64_t>(got);
  }
}

namespace {

int Base64Digit(char c) {
  if (c >= 'A' && c <= 'Z') return c - 'A';
  if (c >= 'a' && c <= 'z') return c - 'a' + 26;
  if (c >= '0' && c <= '9') return c - '0' + 52;
  if (c == '+' || c == '-') return 62;  // '-' and '_': the URL-safe alphabet of RFC 4648
  if (c == '/' || c == '_') return 63;
  return -1;
}

int HexDigit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

}  // namespace

std::vector<unsigned char> DecodeDataUri(const std::string& uri, const std::string& pointer) {
  const std::size_t comma = uri.find(',');
  if (comma == std::string::npos || comma > 200 || uri.substr(0, comma).find(";base64") == std::string::npos) {
    throw LoadError(pointer, "is a data URI without \";base64,\"; only base64 can be read");
  }
  std::size_t end = uri.size();
  while (end > comma + 1 && uri[end - 1] == '=') --end;
  std::vector<unsigned char> bytes;
  bytes.reserve((end - comma) / 4 * 3 + 3);
  std::uint32_t bits = 0;
  int count = 0;
  for (std::size_t i = comma + 1; i < end; ++i) {
    const int digit = Base64Digit(uri[i]);
    if (digit < 0)
      throw LoadError(pointer, "is not base64 at character " + std::to_string(i) + "; export the file again");
    bits = (bits << 6 | static_cast<std::uint32_t>(digit)) & 0xFFFFFF;
    count += 6;
    if (count >= 8) {
      count -= 8;
      bytes.push_back(static_cast<unsigned char>(bits >> count & 0xFF));
    }
  }
  return bytes;
}

namespace {

// Each part of a path, between its slashes.
template <class Use>
void ForEachPart(std::string_view path, Use use) {
  for (std::size_t at = 0; at <= path.size();) {
    const std::size_t end = std::min(path.find('/', at), path.size());
    use(path.substr(at, end - at), end == path.size());
    at = end + 1;
  }
}

}  // namespace

bool IsPathBeneath(std::string_view path) {
  constexpr std::string_view kElsewhere("\\:\0", 3);
  bool beneath = path.size() <= kMaxPathBeneath && path.find_first_of(kElsewhere) == std::string_view::npos;
  ForEachPart(path, [&](std::string_view part, bool) { beneath &= !part.empty() && part != "." && part != ".."; });
  return beneath;
}

std::string PathBeneath(const std::string& uri, const std::string& pointer) {
  std::string decoded;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const int high = uri[i] == '%' && i + 2 < uri.size() ? HexDigit(uri[i + 1]) : -1;
    const int low = high >= 0 ? HexDigit(uri[i + 2]) : -1;
    if (low >= 0) {
      decoded += static_cast<char>(high * 16 + low);
      i += 2;
    } else {
      decoded += uri[i];
    }
  }
  std::string path;
  ForEachPart(decoded, [&](std::string_view part, bool last) {
    if (part != "." || last) path.append(part).append(last ? "" : "/");
  });
  if (!IsPathBeneath(path)) {
    throw LoadError(pointer, "names \"" + uri.substr(0, 60) +
                                 "\"; only files in the document's own folder and the folders in it are read: move it "
                                 "there or export as .glb");
  }
  return path;
}

int FilesInFolder::OpenBeside(const std::string& name) {
  base::UniqueFd at;
  int file = -1;
  ForEachPart(name, [&](std::string_view part, bool last) {
    if (!IsPathBeneath(part)) throw LoadError("", "is no path beneath its folder");
    if (!at) at.Reset(open(folder_.c_str(), O_PATH | O_DIRECTORY | O_CLOEXEC));
    const std::string one(part);
    const int flags = last ? O_RDONLY | O_NONBLOCK : O_PATH | O_DIRECTORY;
    const int next = at ? openat(at.get(), one.c_str(), flags | O_NOFOLLOW | O_CLOEXEC) : -1;
    if (next < 0) {
      const int error = errno;
      struct stat status {};
      const bool link =
          at && fstatat(at.get(), one.c_str(), &status, AT_SYMLINK_NOFOLLOW) == 0 && S_ISLNK(status.st_mode);
      throw LoadError("", "cannot be opened (" +
                              (link ? "\"" + one + "\" is a link, which is not followed" : ReasonOf(error)) +
                              "); check the path and its permissions");
    }
    last ? static_cast<void>(file = next) : at.Reset(next);
  });
  return file;
}

}  // namespace omni::scene
