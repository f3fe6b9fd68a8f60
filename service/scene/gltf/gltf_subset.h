// The part of a document that haptics needs: positions and indices of chosen meshes, what moves these positions (morph
// targets, joints), texture coordinates where a haptic texture needs them, normals and colours for a picture,
// transforms of instances; checked against the document's own limits, their bytes read.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/mat4x4.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "service/haptics/scene/scene.h"
#include "service/scene/gltf/gltf_file.h"
#include "service/scene/gltf/json_reading.h"

namespace omni::scene {

// Which accessors may be read as what: type, and component types by OpenGL's numbers.
enum Use : unsigned {
  kIndex = 1,
  kPosition = 2,
  kUv = 4,
  kVector = 8,
  kRotation = 16,
  kNormal = 32,
  kColour3 = 64,
  kColour4 = 128,
  kJoints = 256,
  kWeights = 512,
  kMatrix = 1024
};

struct UseRow {
  Use use;
  const char* type;
  std::size_t components;
  const char* allowed;
};
const UseRow& RowOf(Use use);

struct ComponentRow {
  std::uint64_t type;  // OpenGL's number
  std::size_t bytes;
  unsigned uses;  // integers for positions, coordinates and normals: KHR_mesh_quantization
};
// Of `parent`/componentType. Throws LoadError when it is not allowed for this use.
const ComponentRow& ComponentOf(const Json& parent, const std::string& pointer, Use use);

// Of a type that ComponentOf has returned.
std::size_t ComponentBytes(std::uint64_t type);

// A morph target that moves vertices: times this weight.
struct MorphWeight {
  std::uint32_t target = 0;
  double weight = 0;                                     // not 0
  auto operator<=>(const MorphWeight&) const = default;  // NOLINT(modernize-use-nullptr): seen in generated code
};

// A mesh in one shape; MeshRequests (mesh_requests.h) makes them.
struct MeshRequest {
  std::uint32_t mesh = 0;             // index into /meshes
  std::optional<std::size_t> skin;    // number of a SkinRequest
  std::vector<MorphWeight> morph;     // each target at most once
  std::vector<std::uint8_t> uv_sets;  // of each primitive: bit k requests TEXCOORD_k; those beyond the list need none
  bool paint = false;                 // NORMAL and COLOR_0 too, where they are
};

// A skin, and where its joints are: joint -> scene.
struct SkinRequest {
  std::uint32_t skin = 0;  // index into /skins
  std::vector<glm::dmat4> joints;
};

// An accessor whose bytes were read, in Subset::bytes. Elements are `width` components wide.
struct SubsetAccessor {
  std::uint64_t component = 0;  // OpenGL's number of its type
  bool normalized = false;
  std::size_t width = 1;
  std::size_t count = 0;
  bool zeros = true;  // without data of its own; sparse values replace some
  std::size_t offset = 0, stride = 0;
  std::size_t changed = 0;  // elements that are replaced
  std::uint64_t index_component = 0;
  std::size_t index_offset = 0, value_offset = 0;
};

// The accessors of EXT_mesh_gpu_instancing of a node.
struct SubsetInstances {
  std::uint32_t node = 0;
  std::uint64_t count = 0;
  std::optional<std::size_t> translation, rotation, scale;  // accessors of the subset
};

struct SubsetSkin {
  SkinRequest from;
  std::optional<std::size_t> inverse_bind;  // accessor of the subset; none: all are the identity
};

struct SubsetPrimitive {
  std::size_t request = 0;  // that it is of
  std::uint32_t mesh = 0;   // in the original document
  std::uint32_t primitive = 0;
  std::string pointer;         // /meshes/0/primitives/1
  std::uint64_t bytes = 0;     // read for it
  std::string skipped;         // why it is not in the subset; empty: it is, in the order of this list
  std::uint8_t uv_sets = 0;    // bit k: TEXCOORD_k was requested and is there
  std::uint32_t accessor = 0;  // POSITION, in the original document (for messages)
  std::uint64_t mode = 4;      // 4 triangles, 5 strip, 6 fan
  // Accessors of the subset.
  std::size_t positions = 0;
  std::optional<std::size_t> indices, normals, colours;
  std::array<std::size_t, haptics::kMaxUvSets> uv{};
  std::vector<std::pair<std::size_t, double>> morph;            // displacements, and their weights
  std::optional<std::size_t> skin;                              // of the subset; none: the node places it
  std::vector<std::pair<std::size_t, std::size_t>> influences;  // JOINTS_n and WEIGHTS_n, with a skin
};

struct Subset {
  std::vector<SubsetPrimitive> primitives;
  std::vector<SubsetInstances> instances;
  std::vector<SubsetSkin> skins;
  std::vector<SubsetAccessor> accessors;
  std::vector<unsigned char> bytes;
};

// Throws LoadError on anything that violates glTF 2.0. `instanced`: nodes whose instances are wanted.
Subset BuildSubset(GltfFile& file, const std::vector<MeshRequest>& meshes, const std::vector<std::uint32_t>& instanced,
                   std::vector<SkinRequest> skins = {});

}  // namespace omni::scene
