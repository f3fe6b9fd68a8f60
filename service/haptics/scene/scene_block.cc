#include "service/haptics/scene/scene_block.h"

#include <cstring>

namespace omni::haptics {
namespace {

class Writer {
  static constexpr std::size_t kAlignment = 64;  // a cache line

 public:
  explicit Writer(std::size_t bytes) : block_(bytes) {}

  template <class T>
  static constexpr std::size_t Aligned(std::size_t count) {
    return (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
  }
  template <class T>
  std::uint64_t Put(const std::vector<T>& values) {
    const std::size_t offset = used_;
    if (!values.empty()) std::memcpy(block_.data() + offset, values.data(), values.size() * sizeof(T));
    used_ += Aligned<T>(values.size());
    return offset;
  }
  void Skip(std::size_t bytes) { used_ += bytes; }
  SceneBlock Take() { return std::move(block_); }
  void PutHeader(const SceneHeader& header) { std::memcpy(block_.data(), &header, sizeof header); }

 private:
  SceneBlock block_;
  std::size_t used_ = 0;
};

}  // namespace

Scene MakeScene(const SceneParts& parts) {
  const std::size_t header_bytes = Writer::Aligned<SceneHeader>(1);
  const std::size_t bytes =
      header_bytes + Writer::Aligned<Material>(parts.materials.size()) +
      Writer::Aligned<Vertex>(parts.vertices.size()) + Writer::Aligned<Triangle>(parts.triangles.size()) +
      Writer::Aligned<TreeNode>(parts.nodes.size()) + Writer::Aligned<TrianglePacket>(parts.packets.size()) +
      Writer::Aligned<Object>(parts.objects.size()) + Writer::Aligned<Region>(parts.regions.size()) +
      Writer::Aligned<WallNode>(parts.wall_nodes.size()) + Writer::Aligned<WallSegment>(parts.wall_segments.size()) +
      Writer::Aligned<Texture>(parts.textures.size()) + Writer::Aligned<std::uint8_t>(parts.texels.size()) +
      Writer::Aligned<CornerUv>(parts.uvs.size());
  Writer writer(bytes);
  SceneHeader header = parts.header;
  header.magic = kSceneMagic;
  header.version = kSceneVersion;
  header.bytes = bytes;
  header.vertex_count = static_cast<std::uint32_t>(parts.vertices.size());
  header.triangle_count = static_cast<std::uint32_t>(parts.triangles.size());
  header.node_count = static_cast<std::uint32_t>(parts.nodes.size());
  header.packet_count = static_cast<std::uint32_t>(parts.packets.size());
  header.object_count = static_cast<std::uint32_t>(parts.objects.size());
  header.region_count = static_cast<std::uint32_t>(parts.regions.size());
  header.material_count = static_cast<std::uint32_t>(parts.materials.size());
  header.wall_node_count = static_cast<std::uint32_t>(parts.wall_nodes.size());
  header.wall_segment_count = static_cast<std::uint32_t>(parts.wall_segments.size());
  header.texture_count = static_cast<std::uint32_t>(parts.textures.size());
  header.texel_count = static_cast<std::uint32_t>(parts.texels.size());
  header.uv_count = static_cast<std::uint32_t>(parts.uvs.size());
  writer.Skip(header_bytes);
  header.materials = writer.Put(parts.materials);
  header.vertices = writer.Put(parts.vertices);
  header.triangles = writer.Put(parts.triangles);
  header.nodes = writer.Put(parts.nodes);
  header.packets = writer.Put(parts.packets);
  header.objects = writer.Put(parts.objects);
  header.regions = writer.Put(parts.regions);
  header.wall_nodes = writer.Put(parts.wall_nodes);
  header.wall_segments = writer.Put(parts.wall_segments);
  header.textures = writer.Put(parts.textures);
  header.texels = writer.Put(parts.texels);
  header.uvs = writer.Put(parts.uvs);
  writer.PutHeader(header);
  return Scene(writer.Take());
}

}  // namespace omni::haptics
