#include "service/scene/gltf/file_bytes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdint>
#include <span>
#include <system_error>

#include "service/scene/gltf/json_reading.h"

namespace omni::scene {
namespace {

std::string ReasonOf(int error) { return std::error_code(error, std::generic_category()).message(); }

}  // namespace

FileBytes::~FileBytes() {
  if (descriptor_ >= 0) close(descriptor_);
}

int OpenForReading(const std::string& path, bool follow_links) {
  // O_NONBLOCK: opening a FIFO must not wait for its other end; it is refused by FileBytes.
  const int descriptor = open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | (follow_links ? 0 : O_NOFOLLOW));
  if (descriptor < 0)
    throw LoadError("", "cannot be opened (" + ReasonOf(errno) + "); check the path and its permissions");
  return descriptor;
}

void FileBytes::Open(const std::string& path, std::uint64_t max_bytes, bool follow_links) {
  TakeDescriptor(OpenForReading(path, follow_links), max_bytes);
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

bool IsLocalName(std::string_view name) {
  constexpr std::string_view kElsewhere("/\\:\0", 4);
  return !name.empty() && name != "." && name != ".." && name.find_first_of(kElsewhere) == std::string_view::npos;
}

std::string LocalFileName(const std::string& uri, const std::string& pointer) {
  std::string name;
  for (std::size_t i = 0; i < uri.size(); ++i) {
    const int high = uri[i] == '%' && i + 2 < uri.size() ? HexDigit(uri[i + 1]) : -1;
    const int low = high >= 0 ? HexDigit(uri[i + 2]) : -1;
    if (low >= 0) {
      name += static_cast<char>(high * 16 + low);
      i += 2;
    } else {
      name += uri[i];
    }
  }
  if (name.starts_with("./")) name.erase(0, 2);
  if (!IsLocalName(name)) {
    throw LoadError(
        pointer,
        "names \"" + uri.substr(0, 60) +
            "\"; buffers are read only from files in the document's own folder: move it there or export as .glb");
  }
  return name;
}

}  // namespace omni::scene
