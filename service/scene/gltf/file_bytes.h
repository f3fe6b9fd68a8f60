// The bytes of a document. A regular file is read by byte ranges with pread; what was read is counted, and added to a
// digest.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "service/base/work_watch.h"
#include "service/scene/cache/sha256.h"
#include "service/scene/scene_file.h"

namespace omni::scene {

class FileBytes {
 public:
  FileBytes() = default;
  FileBytes(const FileBytes&) = delete;
  FileBytes& operator=(const FileBytes&) = delete;
  ~FileBytes();

  // Throws LoadError: missing, not a regular file, unreadable, or larger than `max_bytes`.
  void Open(const std::string& path, std::uint64_t max_bytes);

  // The same for an open descriptor, which stays the caller's.
  void OpenDescriptor(int descriptor, std::uint64_t max_bytes);

  // The same, and it is ours from now on.
  void TakeDescriptor(int descriptor, std::uint64_t max_bytes);

  // Everything read from now on is added to `digest`, which outlives this.
  void AddTo(Sha256* digest) { digest_ = digest; }

  // Reading can be ended by `watch`, which outlives this.
  void WatchBy(const base::WorkWatch* watch) { watch_ = watch; }

  std::uint64_t size() const { return size_; }
  std::uint64_t bytes_read() const { return bytes_read_; }

  // Fills [to, to + count) from `offset`. Throws LoadError when the file ends before.
  void Read(std::uint64_t offset, void* to, std::size_t count);

 private:
  void Examine(std::uint64_t max_bytes);

  int descriptor_ = -1;
  std::uint64_t size_ = 0;
  std::uint64_t bytes_read_ = 0;
  Sha256* digest_ = nullptr;
  const base::WorkWatch* watch_ = nullptr;
};

// URIs of glTF buffers: embedded data, and names of files beside the document.

// "data:...;base64,..." -> bytes. Throws LoadError.
std::vector<unsigned char> DecodeDataUri(const std::string& uri, const std::string& pointer);

// A file for reading; it may turn out to be none (FileBytes checks). Throws LoadError.
int OpenForReading(const std::string& path);

class FilesInFolder final : public FilesBeside {
 public:
  explicit FilesInFolder(const std::string& folder)
      : folder_(folder.empty() ? "." : folder) {}  // empty: the working folder

  // Follows no link on the way from the folder to the file, so that it is beneath the folder whatever others do there.
  int OpenBeside(const std::string& name) override;

 private:
  const std::string folder_;
};

inline constexpr std::size_t kMaxPathBeneath = 1024;

// A file in the document's own folder or beneath it, "textures/clay.bin": no scheme, "..", backslash or NUL byte, and
// not absolute. A scene file must not make the service open files elsewhere.
bool IsPathBeneath(std::string_view path);

// The percent-decoded path of such a file. Throws LoadError on any other place.
std::string PathBeneath(const std::string& uri, const std::string& pointer);

}  // namespace omni::scene
