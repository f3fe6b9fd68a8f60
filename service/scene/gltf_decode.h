// Triangles out of a small, checked binary glTF. tinygltf is confined to gltf_decode.cc.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "service/base/vec.h"
#include "service/scene/gltf_subset.h"

namespace omni::scene {

struct DecodedPrimitive {
  std::vector<base::Vec3> positions;  // glTF frame of the mesh; only vertices that a triangle uses
  std::vector<std::array<std::uint32_t, 3>> triangles;
};

// One entry per primitive of `subset` that is not skipped, in order. Throws LoadError: an index beyond the vertices, a
// vertex that is not finite.
std::vector<DecodedPrimitive> DecodeSubset(const Subset& subset);

}  // namespace omni::scene
