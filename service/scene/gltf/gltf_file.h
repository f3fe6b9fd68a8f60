// The container: binary glTF (header, JSON chunk, BIN chunk) or JSON text, and where the bytes of its buffers are.
// Only the JSON is read at once; buffers are read by ranges.
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <string>
#include <vector>

#include "service/scene/gltf/file_bytes.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/scene_file.h"

namespace omni::scene {

class GltfFile {
 public:
  // Throws LoadError. Appends warnings to `report`.
  void Open(const std::string& path, const LoadOptions& options, LoadReport& report);

  const Json& root() const { return document_.root(); }
  std::uint64_t file_bytes() const { return file_.size(); }
  std::uint64_t json_bytes() const { return json_bytes_; }                   // of its text
  std::uint64_t document_bytes() const { return document_.memory_bytes(); }  // of what root() refers to
  std::uint64_t bytes_read() const;
  std::uint64_t stored_bytes() const;                 // of the file and of those beside it that were opened
  Digest FinishDigest() { return digest_.Finish(); }  // once: of all bytes read so far, in their order

  // The stored bytes of image `image`: of a bufferView, a data URI or a file beside the document. Throws LoadError.
  std::vector<unsigned char> ReadImage(std::uint32_t image, std::uint64_t max_bytes);

  // Whether there are bytes for a buffer: a fallback of compressed data may have none.
  bool HasBuffer(std::uint32_t buffer);

  // Bytes [offset, offset + count) of buffer `buffer`. Throws LoadError when they are not there.
  void ReadBuffer(std::uint32_t buffer, std::uint64_t offset, void* to, std::size_t count);

 private:
  struct Buffer {
    std::uint64_t length = 0;
    FileBytes* file = nullptr;  // nullptr: `embedded`
    std::uint64_t offset = 0;
    std::vector<unsigned char> embedded;  // decoded data URI
  };
  std::string ReadJsonText(LoadReport& report);
  Buffer& OpenBuffer(std::uint32_t index);
  FileBytes& OpenBeside(const std::string& uri, const std::string& pointer);
  void OpenExternal(const std::string& uri, const std::string& pointer, Buffer& buffer);

  std::string path_;
  bool in_memory_ = false;
  FilesBeside* beside_ = nullptr;
  const base::WorkWatch* watch_ = nullptr;
  std::uint64_t max_file_bytes_ = 0;
  Sha256 digest_;
  FileBytes file_;
  std::deque<FileBytes> external_;
  base::JsonDocument document_;
  std::uint64_t json_bytes_ = 0;
  bool has_bin_ = false;
  std::uint64_t bin_offset_ = 0, bin_length_ = 0;
  std::map<std::uint32_t, Buffer> buffers_;
};

}  // namespace omni::scene
