// EXT_meshopt_compression and KHR_meshopt_compression: buffer views whose bytes are compressed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>

#include "service/scene/gltf/json_reading.h"

namespace omni::scene {

inline constexpr std::uint64_t kMaxViewOffset = 1ull << 40;  // of bytes in a buffer

struct MeshoptView {
  std::string pointer;  // /bufferViews/0/extensions/EXT_meshopt_compression
  std::uint32_t buffer = 0;
  std::uint64_t offset = 0, length = 0;  // of the compressed bytes, in the buffer
  std::uint64_t count = 0;
  std::size_t stride = 0;
  enum class Mode { kAttributes, kTriangles, kIndices } mode = Mode::kAttributes;
  enum class Filter { kNone, kOctahedral, kQuaternion, kExponential } filter = Filter::kNone;

  std::uint64_t decoded_bytes() const { return count * stride; }
};

// None: the view is not compressed. Throws LoadError on what the extension does not allow.
std::optional<MeshoptView> MeshoptOf(const Json& root, std::uint32_t view);

// Fills `decoded`, of view.decoded_bytes(). Throws LoadError.
void DecodeMeshopt(const MeshoptView& view, std::span<const unsigned char> compressed,
                   std::span<unsigned char> decoded);

// Of all compressed views of a document, compressed and decoded; at most.
std::uint64_t MeshoptBytes(const Json& root);

}  // namespace omni::scene
