// Byte ranges of buffer views, one after another: read from their buffers, or decoded. A range requested twice is there
// once.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "service/scene/gltf/gltf_file.h"
#include "service/scene/gltf/meshopt_view.h"

namespace omni::scene {

class ViewBytes {
 public:
  explicit ViewBytes(GltfFile& file) : file_(file) {}

  // Where `bytes` bytes at `offset` of bufferView `view` are now. `pointer`: who needs them. Throws LoadError.
  std::size_t Add(std::uint32_t view, const std::string& pointer, std::uint64_t offset, std::uint64_t bytes);

  // All bytes of a view as they are stored. Throws LoadError.
  std::vector<unsigned char> ReadStored(std::uint32_t view);

  // Room for bytes that `pointer` is decoded to. Throws LoadError, and does so before it is decoded by CheckRoom, which
  // gives what there is.
  std::uint64_t CheckRoom(const std::string& pointer, std::uint64_t bytes) const;
  std::size_t ReserveRoom(const std::string& pointer, std::uint64_t bytes);
  unsigned char* data(std::size_t at) { return bytes_.data() + at; }

  std::vector<unsigned char> TakeBytes() { return std::move(bytes_); }
  std::uint64_t fresh_bytes() { return std::exchange(fresh_bytes_, 0); }  // read since the last call

 private:
  struct Range {
    std::uint32_t buffer;
    std::uint64_t offset, bytes;
    auto operator<=>(const Range&) const = default;  // NOLINT(modernize-use-nullptr): seen in generated code
  };

  Range RangeOf(std::uint32_t view) const;
  std::size_t Read(const Range& range);
  std::vector<unsigned char> ReadWhole(const Range& range);
  std::size_t DecodedView(const MeshoptView& view, std::uint32_t number);
  bool HasFallback(std::uint32_t buffer);

  GltfFile& file_;
  std::map<Range, std::size_t> places_;
  std::map<std::uint32_t, std::size_t> decoded_places_;  // of views
  std::map<std::uint32_t, bool> fallbacks_;              // by buffer
  std::vector<unsigned char> bytes_;
  std::uint64_t fresh_bytes_ = 0, decoded_bytes_ = 0;
  std::uint64_t compressed_bytes_ = 0;  // read to be decoded
};

}  // namespace omni::scene
