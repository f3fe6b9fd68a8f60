// The part of a document that touch needs: positions and indices of chosen meshes, checked against the document's own
// limits, their bytes read and packed into a small binary glTF without anything else.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "service/scene/gltf_file.h"
#include "service/scene/json_reading.h"

namespace omni::scene {

struct SubsetPrimitive {
  std::uint32_t mesh = 0;  // in the original document
  std::uint32_t primitive = 0;
  std::string pointer;         // /meshes/0/primitives/1
  std::uint64_t bytes = 0;     // read for it
  std::string skipped;         // why it is not in the subset; empty: it is, in the order of this list
  std::uint32_t accessor = 0;  // POSITION, in the original document (for messages)
};

struct Subset {
  std::vector<SubsetPrimitive> primitives;
  std::vector<unsigned char> glb;  // one mesh for each primitive that is not skipped
};

// Throws LoadError on anything that is not as glTF 2.0 says. `meshes`: indices into /meshes, each once.
Subset BuildSubset(GltfFile& file, const std::vector<std::uint32_t>& meshes);

}  // namespace omni::scene
