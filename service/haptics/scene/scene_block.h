// Lays the parts of a scene out as one relocatable block. Set-up only.
#pragma once

#include <vector>

#include "service/haptics/scene/scene.h"

namespace omni::haptics {

inline constexpr std::uint32_t kSceneMagic = 0x31534D4F;  // "OMS1"
inline constexpr std::uint32_t kSceneVersion = 8;

struct SceneParts {
  SceneHeader header{};
  std::vector<Vertex> vertices;
  std::vector<std::uint32_t> region_of;  // of each vertex, or empty
  std::vector<Triangle> triangles;
  std::vector<TreeNode> nodes;
  std::vector<Object> objects;
  std::vector<Region> regions;
  std::vector<Material> materials;
  std::vector<WallNode> wall_nodes;
  std::vector<WallSegment> wall_segments;
  std::vector<Texture> textures;
  std::vector<Relief> reliefs;
  std::vector<std::uint8_t> texels;
  std::vector<CornerUv> uvs;
};

// Fills in counts and offsets. Each part is freed once it is in the block: both together would be twice the scene.
Scene MakeScene(SceneParts parts, const base::WorkWatch& watch);

}  // namespace omni::haptics
