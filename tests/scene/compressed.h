// Files with compressed meshes, made by the encoders of the libraries that ours are decoded by.
#pragma once

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include <meshoptimizer.h>

#include "tests/scene/files.h"

namespace omni::scene::test {

inline constexpr const char* kMeshopt = "EXT_meshopt_compression";

inline std::string MeshoptVertices(const std::string& bytes, std::size_t stride) {
  const std::size_t count = bytes.size() / stride;
  std::string encoded(meshopt_encodeVertexBufferBound(count, stride), '\0');
  encoded.resize(meshopt_encodeVertexBuffer(reinterpret_cast<unsigned char*>(encoded.data()), encoded.size(),
                                            bytes.data(), count, stride));
  return encoded;
}

inline std::string MeshoptIndices(const std::vector<unsigned>& indices, bool triangles) {
  const std::size_t vertices = *std::max_element(indices.begin(), indices.end()) + 1;
  const std::size_t bound = triangles ? meshopt_encodeIndexBufferBound(indices.size(), vertices)
                                      : meshopt_encodeIndexSequenceBound(indices.size(), vertices);
  std::string encoded(bound, '\0');
  auto* to = reinterpret_cast<unsigned char*>(encoded.data());
  encoded.resize(triangles ? meshopt_encodeIndexBuffer(to, bound, indices.data(), indices.size())
                           : meshopt_encodeIndexSequence(to, bound, indices.data(), indices.size()));
  return encoded;
}

// Bytes behind those that the model's first buffer has; where.
inline std::size_t Append(Model& model, const std::string& bytes) {
  model.bin.resize((model.bin.size() + 3) / 4 * 4, '\0');
  const std::size_t at = model.bin.size();
  model.bin += bytes;
  model.json["buffers"][0]["byteLength"] = model.bin.size();
  return at;
}

// Bufferview `view` holds `count` elements of `stride` bytes in `encoded`; as gltfpack writes it, its own buffer has no
// data.
inline void Compress(Model& model, std::size_t view, const std::string& encoded, std::size_t count, std::size_t stride,
                     const char* mode, const char* filter = nullptr, const char* extension = kMeshopt) {
  if (model.json["buffers"].size() == 1) {
    model.json["buffers"].push_back({{"byteLength", 1 << 20}, {"extensions", {{extension, {{"fallback", true}}}}}});
  }
  Json compressed = {{"buffer", 0},
                     {"byteOffset", Append(model, encoded)},
                     {"byteLength", encoded.size()},
                     {"byteStride", stride},
                     {"count", count},
                     {"mode", mode}};
  if (filter) compressed["filter"] = filter;
  Json& json = model.json["bufferViews"][view];
  json["buffer"] = 1;
  json["byteLength"] = count * stride;
  json["extensions"] = {{extension, compressed}};
  model.json["extensionsUsed"] = {extension};
  model.json["extensionsRequired"] = {extension};
}

// The tetrahedron, with nothing of it uncompressed.
inline Model MeshoptTetra(bool triangles = true, std::size_t index_stride = 2) {
  Model model = Tetra();
  const std::vector<std::uint16_t> indices = TetraIndices();
  model.bin.clear();
  Compress(model, 0, MeshoptVertices(Bytes(TetraPositions()), 12), 4, 12, "ATTRIBUTES");
  Compress(model, 1, MeshoptIndices({indices.begin(), indices.end()}, triangles), 12, index_stride,
           triangles ? "TRIANGLES" : "INDICES");
  model.json["accessors"][1]["componentType"] = index_stride == 2 ? 5123 : 5125;
  return model;
}

}  // namespace omni::scene::test
