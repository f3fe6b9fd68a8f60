#include "service/haptics/scene/scene_block.h"

#include <algorithm>
#include <cstring>

#include "service/base/free_memory.h"

namespace omni::haptics {
namespace {

class Writer {
  static constexpr std::size_t kAlignment = 64;  // a cache line

 public:
  Writer(std::size_t bytes, const base::WorkWatch& watch) : block_(bytes), watch_(watch) {}

  template <class T>
  static constexpr std::size_t Aligned(std::size_t count) {
    return (count * sizeof(T) + kAlignment - 1) / kAlignment * kAlignment;
  }
  template <class T>
  std::uint64_t Put(std::vector<T>& values) {
    const std::size_t offset = used_, bytes = values.size() * sizeof(T);
    for (std::size_t done = 0; done < bytes; done += kChunk) {
      const std::size_t now = std::min(kChunk, bytes - done);
      std::memcpy(block_.data() + offset + done, reinterpret_cast<const std::byte*>(values.data()) + done, now);
      watch_.Did(now / 1024);
    }
    Clear(offset + bytes, Aligned<T>(values.size()) - bytes);
    base::FreeMemory(values);
    return offset;
  }
  void PutHeader(const SceneHeader& header, std::size_t bytes) {
    std::memcpy(block_.data(), &header, sizeof header);
    std::memset(block_.data() + sizeof header, 0, bytes - sizeof header);
  }
  void Skip(std::size_t bytes) { used_ += bytes; }
  SceneBlock Take() { return std::move(block_); }

 private:
  static constexpr std::size_t kChunk = 1 << 20;

  // What lies between two parts: equal parts give equal bytes.
  void Clear(std::size_t from, std::size_t bytes) {
    std::memset(block_.data() + from, 0, bytes);
    used_ = from + bytes;
  }

  SceneBlock block_;  // not zero when it is made
  const base::WorkWatch& watch_;
  std::size_t used_ = 0;
};

}  // namespace

Scene MakeScene(SceneParts parts, const base::WorkWatch& watch) {
  const std::size_t header_bytes = Writer::Aligned<SceneHeader>(1);
  const std::size_t bytes =
      header_bytes + Writer::Aligned<Material>(parts.materials.size()) +
      Writer::Aligned<Vertex>(parts.vertices.size()) + Writer::Aligned<std::uint32_t>(parts.region_of.size()) +
      Writer::Aligned<Triangle>(parts.triangles.size()) + Writer::Aligned<TreeNode>(parts.nodes.size()) +
      Writer::Aligned<Object>(parts.objects.size()) + Writer::Aligned<Region>(parts.regions.size()) +
      Writer::Aligned<WallNode>(parts.wall_nodes.size()) + Writer::Aligned<WallSegment>(parts.wall_segments.size()) +
      Writer::Aligned<Texture>(parts.textures.size()) + Writer::Aligned<Relief>(parts.reliefs.size()) +
      Writer::Aligned<std::uint8_t>(parts.texels.size()) + Writer::Aligned<CornerUv>(parts.uvs.size());
  Writer writer(bytes, watch);
  SceneHeader header = parts.header;
  header.magic = kSceneMagic;
  header.version = kSceneVersion;
  header.bytes = bytes;
  header.vertex_count = static_cast<std::uint32_t>(parts.vertices.size());
  header.region_of_count = static_cast<std::uint32_t>(parts.region_of.size());
  header.triangle_count = static_cast<std::uint32_t>(parts.triangles.size());
  header.node_count = static_cast<std::uint32_t>(parts.nodes.size());
  header.object_count = static_cast<std::uint32_t>(parts.objects.size());
  header.region_count = static_cast<std::uint32_t>(parts.regions.size());
  header.material_count = static_cast<std::uint32_t>(parts.materials.size());
  header.wall_node_count = static_cast<std::uint32_t>(parts.wall_nodes.size());
  header.wall_segment_count = static_cast<std::uint32_t>(parts.wall_segments.size());
  header.texture_count = static_cast<std::uint32_t>(parts.textures.size());
  header.relief_count = static_cast<std::uint32_t>(parts.reliefs.size());
  header.texel_count = static_cast<std::uint32_t>(parts.texels.size());
  header.uv_count = static_cast<std::uint32_t>(parts.uvs.size());
  writer.Skip(header_bytes);
  header.materials = writer.Put(parts.materials);
  header.vertices = writer.Put(parts.vertices);
  header.region_of = writer.Put(parts.region_of);
  header.triangles = writer.Put(parts.triangles);
  header.nodes = writer.Put(parts.nodes);
  header.objects = writer.Put(parts.objects);
  header.regions = writer.Put(parts.regions);
  header.wall_nodes = writer.Put(parts.wall_nodes);
  header.wall_segments = writer.Put(parts.wall_segments);
  header.textures = writer.Put(parts.textures);
  header.reliefs = writer.Put(parts.reliefs);
  header.texels = writer.Put(parts.texels);
  header.uvs = writer.Put(parts.uvs);
  writer.PutHeader(header, header_bytes);
  return Scene(writer.Take());
}

}  // namespace omni::haptics
