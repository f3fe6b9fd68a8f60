#include "service/haptics/scene_block.h"

#include <cstring>
#include <span>

namespace omni::haptics {
namespace {

// FNV-1a over 64-bit words instead of bytes, folded at the end: fast enough for 100 MB blocks.
class Hasher {
 public:
  void Add(std::uint64_t word) { state_ = (state_ ^ word) * 0x100000001b3ULL ^ (state_ >> 29); }
  void Add(double x) {
    std::uint64_t word = 0;
    std::memcpy(&word, &x, sizeof word);
    Add(word);
  }
  void Add(std::span<const std::byte> bytes) {
    std::size_t i = 0;
    for (; i + 8 <= bytes.size(); i += 8) {
      std::uint64_t word = 0;
      std::memcpy(&word, bytes.data() + i, 8);
      Add(word);
    }
    for (; i < bytes.size(); ++i) Add(static_cast<std::uint64_t>(bytes[i]));
  }
  std::uint64_t Finish() const { return state_ ^ (state_ >> 32); }

 private:
  std::uint64_t state_ = 0xcbf29ce484222325ULL;
};

// By member: a Material has padding, whose bits mean nothing.
void Add(Hasher& h, const Material& m) {
  for (const double x : {m.stiffness_N_m,
                         m.damping_Ns_m,
                         m.static_friction,
                         m.dynamic_friction,
                         m.restitution,
                         m.viscosity_Ns_m,
                         m.texture_amplitude_m,
                         m.texture_wavelength_m,
                         m.texture_gain,
                         m.vibration_amplitude_N,
                         m.vibration_frequency_Hz,
                         m.pop_through_N,
                         m.magnet_max_force_N,
                         m.magnet_range_m,
                         m.temperature_K,
                         m.softness.young_modulus_Pa,
                         m.softness.poisson_ratio,
                         m.softness.thickness_m,
                         m.softness.max_depth_m,
                         m.softness.relaxation_time_s,
                         m.softness.fibre_ratio,
                         m.softness.fibre_direction_base[0],
                         m.softness.fibre_direction_base[1],
                         m.softness.fibre_direction_base[2],
                         m.softness.hardening,
                         m.sculpt.radius_m,
                         m.sculpt.snap_m,
                         m.sculpt.grab_force_N,
                         m.sculpt.dwell_s,
                         m.sculpt.resistance_N_m,
                         m.extrude.step_m,
                         m.extrude.grab_force_N,
                         m.extrude.dwell_s}) {
    h.Add(x);
  }
  h.Add(static_cast<std::uint64_t>(m.softness.model));
  h.Add(std::uint64_t{m.extrude.enabled});
  h.Add(static_cast<std::uint64_t>(m.extrude.steps_out));
  h.Add(static_cast<std::uint64_t>(m.extrude.steps_in));
  h.Add(std::uint64_t{m.sculpt.enabled});
  h.Add(static_cast<std::uint64_t>(m.sculpt.falloff));
  h.Add(static_cast<std::uint64_t>(m.sculpt.symmetry));
  for (const std::int32_t texture : {m.stiffness_texture, m.friction_texture, m.vibrotactile_texture}) {
    h.Add(static_cast<std::uint64_t>(texture));
  }
}

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
  std::span<const std::byte> From(std::size_t offset) const { return std::span(block_).subspan(offset); }
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
  header.content_hash = 0;
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
  Hasher hasher;
  writer.PutHeader(header);
  hasher.Add(writer.From(0).first(sizeof header));
  for (const Material& m : parts.materials) Add(hasher, m);
  hasher.Add(writer.From(header.vertices));
  header.content_hash = hasher.Finish();
  writer.PutHeader(header);
  return Scene(writer.Take());
}

}  // namespace omni::haptics
