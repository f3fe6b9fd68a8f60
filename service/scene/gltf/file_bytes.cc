#include "service/scene/gltf/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <span>
#include <system_error>

#include "service/scene/gltf/load_error.h"

namespace omni::scene {
namespace {

std::string ReasonOf(int error) { return std::error_code(error, std::generic_category()).message(); }

}  // namespace

FileBytes::~FileBytes() {
  if (descriptor_ >= 0) close(descriptor_);
}

void FileBytes::Open(const std::string& path, std::uint64_t max_bytes, bool follow_links) {
  // O_NONBLOCK: opening a FIFO must not wait for its other end; it is refused below.
  descriptor_ = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | (follow_links ? 0 : O_NOFOLLOW));
  if (descriptor_ < 0)
    throw LoadError("", "cannot be opened (" + ReasonOf(errno) + "); check the path and its permissions");
  Examine(max_bytes);
}

void FileBytes::OpenDescriptor(int descriptor, std::uint64_t max_bytes) {
  descriptor_ = fcntl(descriptor, F_DUPFD_CLOEXEC, 3);
  if (descriptor_ < 0) throw LoadError("", "cannot be opened (" + ReasonOf(errno) + ")");
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
  const std::span<const std::byte> all(out, count);
  while (count > 0) {
    const ssize_t got = pread(descriptor_, out, count, static_cast<off_t>(offset));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) throw LoadError("", "cannot be read (" + ReasonOf(errno) + ")");
    if (got == 0) throw LoadError("", "became shorter while it was read; wait until it is written, then load it again");
    out += got;
    offset += static_cast<std::uint64_t>(got);
    count -= static_cast<std::size_t>(got);
    bytes_read_ += static_cast<std::uint64_t>(got);
  }
  if (digest_) digest_->Add(all);
}

}  // namespace omni::scene
