// Triangles out of the bytes of a subset.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "service/base/vec.h"
#include "service/base/work_watch.h"
#include "service/haptics/scene/scene_input.h"
#include "service/scene/gltf/gltf_subset.h"

namespace omni::scene {

// Said where a node has a skin, and a primitive of its mesh is not placed by it.
inline constexpr const char* kHasNoJoints = "has no JOINTS_0 and WEIGHTS_0; the node places it, not its joints";

struct DecodedPrimitive {
  std::vector<base::Vec3> positions;  // glTF frame of the mesh, morphed; only vertices that a triangle uses
  bool placed = false;                // its joints have placed it: positions are in the frame of the scene
  bool mirrored = false;              // by them: triangles are inside out
  // Of stored coordinates that are floats: the largest, and its distance to the next float. As placed.
  double float_reach = 0, float_step = 0;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::array<std::vector<haptics::CornerUv>, haptics::kMaxUvSets> uv;  // per triangle, where the subset has them
  std::vector<base::Vec3> normals, colours;  // per vertex, as stored, where the subset has them; else empty
};

// One place of an instanced mesh, in the frame of its node: X = T R S.
struct Instance {
  std::array<double, 3> translation{0, 0, 0};
  std::array<double, 4> rotation{0, 0, 0, 1};  // x, y, z, w; as stored, of any length
  std::array<double, 3> scale{1, 1, 1};
};

struct DecodedSubset {
  std::vector<DecodedPrimitive> primitives;      // those of the subset that are not skipped, in order
  std::vector<std::vector<Instance>> instances;  // as the subset's
};

// Throws LoadError: an index beyond the vertices, a joint beyond its skin's, a vertex or transform that is not finite.
DecodedSubset DecodeSubset(const Subset& subset, const base::WorkWatch& watch = {});

}  // namespace omni::scene
