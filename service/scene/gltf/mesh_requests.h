// The meshes of nodes, each in the shape that it has there: two nodes share one if mesh, skin and weights of morph
// targets are the same. Skins are in the pose of the nodes, and the weights are the default ones: nothing is animated.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <tuple>
#include <vector>

#include "service/scene/gltf/gltf_subset.h"
#include "service/scene/gltf/json_reading.h"
#include "service/scene/gltf/node_tree.h"

namespace omni::scene {

class MeshRequests {
 public:
  // Both outlive this. `nodes`: all of the scene, joints included.
  MeshRequests(const Json& root, const std::vector<NodeVisit>& nodes) : root_(root), nodes_(nodes) {}

  // Number of the request for this node, which has a mesh. Throws LoadError.
  std::size_t Add(const NodeVisit& node);

  std::vector<MeshRequest>& meshes() { return meshes_; }
  const std::vector<MeshRequest>& meshes() const { return meshes_; }
  const std::vector<SkinRequest>& skins() const { return skins_; }

  // Stored bytes of what moves the vertices of a request, at most, and what it takes when it is decoded.
  std::uint64_t ShapeBytes(const MeshRequest& request) const;

 private:
  using Key = std::tuple<std::uint32_t, std::optional<std::size_t>, std::vector<MorphWeight>>;

  std::size_t SkinOf(std::uint32_t skin);
  const std::vector<MorphWeight>& MorphOf(const NodeVisit& node, std::vector<MorphWeight>& own);

  const Json& root_;
  const std::vector<NodeVisit>& nodes_;
  std::vector<MeshRequest> meshes_;
  std::vector<SkinRequest> skins_;
  std::map<Key, std::size_t> numbers_;                              // of meshes_
  std::map<std::uint32_t, std::size_t> skin_numbers_;               // of skins_, by skin
  std::map<std::uint32_t, std::vector<MorphWeight>> mesh_weights_;  // by mesh, where a node has none of its own
  std::vector<const NodeVisit*> by_node_;                           // null: not in the scene
  std::uint64_t joints_ = 0;
};

}  // namespace omni::scene
