// KHR_draco_mesh_compression: the corners and attributes of a primitive in one compressed stream.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>

#include "service/scene/gltf/json_reading.h"

namespace omni::scene {

inline constexpr const char* kDracoExtension = "KHR_draco_mesh_compression";

class DracoMesh {
 public:
  // `triangles` and `vertices`: how many the document says there are. The stream must say the same, which is known
  // before memory is allocated for them, and its attributes, also those that nobody reads, take `most_bytes` at most.
  // `pointer`: of the extension. Throws LoadError.
  DracoMesh(const std::string& pointer, std::span<const unsigned char> stored, std::uint64_t triangles,
            std::uint64_t vertices, std::uint64_t most_bytes);
  ~DracoMesh();
  DracoMesh(const DracoMesh&) = delete;
  DracoMesh& operator=(const DracoMesh&) = delete;

  std::uint64_t triangles() const { return triangles_; }
  std::uint64_t vertices() const { return vertices_; }

  // Three vertices per triangle, each 32 bits.
  void CopyCorners(unsigned char* to) const;

  struct Attribute {
    std::uint64_t component = 0;  // OpenGL's number
    std::size_t width = 0;        // components
  };
  // None: there is none with this number, or its numbers are of a type that glTF has not.
  std::optional<Attribute> Find(std::uint32_t number) const;

  // One that Find has found, for each vertex, without gaps.
  void CopyAttribute(std::uint32_t number, unsigned char* to) const;

 private:
  struct Decoded;
  std::unique_ptr<Decoded> decoded_;
  std::uint64_t triangles_, vertices_;
};

// Half of what decoding the primitives of a mesh takes besides what it gives, at most: it is counted twice, like stored
// bytes (build_estimate.cc). A document says it before it is decoded.
std::uint64_t DracoBytes(const Json& root, std::uint32_t mesh);

}  // namespace omni::scene
