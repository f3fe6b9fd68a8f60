#include "service/haptics/deformable/soft_body.h"

#include <array>
#include <cmath>
#include <cstring>
#include <string>

namespace omni::haptics {
namespace {

constexpr std::uint64_t kSoftAlignment = 16;

std::uint64_t Aligned(std::uint64_t offset) { return (offset + kSoftAlignment - 1) / kSoftAlignment * kSoftAlignment; }

struct SoftSection {
  std::uint64_t offset, bytes;
};

// In the order of the block; also what a loaded header must say.
std::array<SoftSection, 6> SectionsOf(const SoftHeader& h) {
  const std::uint64_t n = h.node_count;
  const std::uint64_t cells = static_cast<std::uint64_t>(h.grid_count[0]) * h.grid_count[1] * h.grid_count[2];
  const std::array<std::uint64_t, 6> sizes{n * sizeof(SoftNode),
                                           h.triangle_count * sizeof(SoftTriangle),
                                           h.skin_count * sizeof(SoftSkin),
                                           cells * sizeof(std::uint32_t),
                                           n * n * sizeof(Float3),
                                           n * (n + 1) / 2 * sizeof(float)};
  std::array<SoftSection, 6> sections{};
  std::uint64_t offset = Aligned(sizeof(SoftHeader));
  for (std::size_t k = 0; k < sections.size(); ++k) {
    sections[k] = {offset, sizes[k]};
    offset = Aligned(offset + sizes[k]);
  }
  return sections;
}

std::uint64_t BytesOf(const SoftHeader& h) { return Aligned(SectionsOf(h)[5].offset + SectionsOf(h)[5].bytes); }

// Also the fields of the header are covered, all but the checksum itself.
std::uint64_t ChecksumOf(std::span<const std::byte> block) {
  SoftHeader header;
  std::memcpy(&header, block.data(), sizeof header);
  header.checksum = 0;
  const auto bytes = std::as_bytes(std::span(&header, 1));
  return SoftHash(block.subspan(sizeof header), SoftHash(bytes));
}

bool CountsPlausible(const SoftHeader& h) {
  if (h.node_count < 3 || h.node_count > kMaxSoftNodes) return false;
  if (h.triangle_count < 1 || h.triangle_count > 4 * kMaxSoftNodes || h.skin_count > 64'000'000) return false;
  for (const std::uint32_t n : h.grid_count) {
    if (n < 1 || n > 64) return false;
  }
  return true;
}

bool NumbersPlausible(const SoftHeader& h) {
  const double positive[] = {h.grid_cell_m, h.cell_m, h.patch_radius_m};
  for (const double x : positive) {
    if (!(x > 0 && x < 1e3)) return false;
  }
  for (const double x : h.grid_lower_m) {
    if (!(std::abs(x) < 1e4)) return false;
  }
  return h.poisson_ratio >= 0 && h.poisson_ratio < 0.5 && h.hardening >= 0 && h.hardening <= 100 &&
         h.relaxing_share >= 0 && h.relaxing_share <= 10 && h.relaxation_time_s >= 0 && h.relaxation_time_s < 1e6;
}

bool IndicesInRange(const SoftBodyView& view) {
  const SoftHeader& h = view.header();
  for (std::uint32_t t = 0; t < h.triangle_count; ++t) {
    for (int k = 0; k < 3; ++k) {
      if (view.GetTriangle(t).node[k] >= h.node_count) return false;
      const std::uint32_t neighbour = view.GetTriangle(t).neighbour[k];
      if (neighbour != kNoSoftTriangle && neighbour >= h.triangle_count) return false;
    }
  }
  for (std::uint32_t v = 0; v < h.skin_count; ++v) {
    if (view.Skin(v).triangle >= h.triangle_count) return false;
  }
  for (std::uint32_t c = 0; c < h.grid_count[0] * h.grid_count[1] * h.grid_count[2]; ++c) {
    if (view.Seed(c) >= h.triangle_count) return false;
  }
  return true;
}

}  // namespace

std::uint64_t SoftHash(std::span<const std::byte> bytes, std::uint64_t hash) {
  std::size_t i = 0;
  for (; i + 8 <= bytes.size(); i += 8) {
    std::uint64_t word = 0;
    std::memcpy(&word, bytes.data() + i, 8);
    hash = (hash ^ word) * 0x100000001B3;
    hash ^= hash >> 29;
  }
  for (; i < bytes.size(); ++i) hash = (hash ^ static_cast<std::uint64_t>(bytes[i])) * 0x100000001B3;
  return hash;
}

std::vector<std::byte> LayOutSoftBody(const SoftParts& parts) {
  SoftHeader h = parts.header;
  h.magic = kSoftMagic;
  h.version = kSoftVersion;
  h.node_count = static_cast<std::uint32_t>(parts.nodes.size());
  h.triangle_count = static_cast<std::uint32_t>(parts.triangles.size());
  h.skin_count = static_cast<std::uint32_t>(parts.skin.size());
  const auto sections = SectionsOf(h);
  h.nodes = sections[0].offset;
  h.triangles = sections[1].offset;
  h.skin = sections[2].offset;
  h.grid = sections[3].offset;
  h.columns = sections[4].offset;
  h.compliance = sections[5].offset;
  h.bytes = BytesOf(h);
  h.checksum = 0;
  std::vector<std::byte> block(h.bytes);
  const void* const data[] = {parts.nodes.data(), parts.triangles.data(), parts.skin.data(),
                              parts.grid.data(),  parts.columns.data(),   parts.compliance.data()};
  for (std::size_t k = 0; k < sections.size(); ++k) {
    if (sections[k].bytes > 0) std::memcpy(block.data() + sections[k].offset, data[k], sections[k].bytes);
  }
  std::memcpy(block.data(), &h, sizeof h);
  h.checksum = ChecksumOf(block);
  std::memcpy(block.data(), &h, sizeof h);
  return block;
}

base::Result<SoftBody> SoftBody::Load(std::span<const std::byte> bytes) {
  if (bytes.size() < sizeof(SoftHeader)) return base::Error{"soft body: the block is shorter than its header"};
  SoftHeader h;
  std::memcpy(&h, bytes.data(), sizeof h);
  if (h.magic != kSoftMagic) return base::Error{"soft body: this is not a soft body block"};
  if (h.version != kSoftVersion) {
    return base::Error{"soft body: the block has version " + std::to_string(h.version) + ", this program reads " +
                       std::to_string(kSoftVersion)};
  }
  if (!CountsPlausible(h) || h.bytes != BytesOf(h) || h.bytes != bytes.size()) {
    return base::Error{"soft body: the block is cut off or its counts are damaged"};
  }
  const auto s = SectionsOf(h);
  const bool in_place = h.nodes == s[0].offset && h.triangles == s[1].offset && h.skin == s[2].offset &&
                        h.grid == s[3].offset && h.columns == s[4].offset && h.compliance == s[5].offset;
  if (!in_place || h.checksum != ChecksumOf(bytes)) return base::Error{"soft body: the block is damaged (checksum)"};
  SoftBody body(std::vector<std::byte>(bytes.begin(), bytes.end()));
  if (!NumbersPlausible(h) || !IndicesInRange(body.view())) {
    return base::Error{"soft body: the block holds numbers out of range"};
  }
  return body;
}

}  // namespace omni::haptics
