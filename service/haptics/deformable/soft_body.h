// A soft body made ready for the tick: one relocatable block (offsets, no pointers), so that it can be cached on disk
// and mapped or copied anywhere. Lengths in m, forces in N, everything in the base frame of the mesh it was made from.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "service/base/result.h"
#include "service/base/vec.h"
#include "service/haptics/deformable/soft_contact_state.h"

namespace omni::haptics {

using base::Vec3;

inline constexpr std::uint32_t kSoftMagic = 0x3154534F;  // "OST1"
inline constexpr std::uint32_t kSoftVersion = 3;
inline constexpr std::uint32_t kMaxSoftNodes = 1024;  // of the coarse surface

struct Float3 {
  float x, y, z;
};

// A corner of the lattice's surface. (4.3)
struct SoftNode {
  Float3 position_base_m;
  Float3 normal;         // unit, outwards
  float compliance_m_N;  // of the body without its local part, along the normal; may be negative
  float modulus_Pa;      // indentation modulus M along the normal
  float curvature_1_m;   // mean, convex > 0
};

struct SoftTriangle {
  std::uint32_t node[3];       // counter-clockwise from outside
  std::uint32_t neighbour[3];  // across node[k] -> node[(k+1)%3]
};

// Where a vertex of the drawn mesh hangs on the coarse surface.
struct SoftSkin {
  std::uint32_t triangle;
  float weights[3];
};

struct SoftHeader {
  std::uint32_t magic, version;
  std::uint64_t bytes;
  std::uint64_t checksum;    // of everything behind the header
  std::uint64_t input_hash;  // of the mesh and the options it was made from
  std::uint32_t node_count, triangle_count, skin_count, tet_count;
  std::uint32_t grid_count[3];  // cells of the seed grid
  std::uint32_t reserved;
  double grid_lower_m[3];
  double grid_cell_m;
  double cell_m;          // of the lattice
  double patch_radius_m;  // of the pressure a column answers to
  double poisson_ratio;
  double hardening;       // added slope of the force gain, per local depth over radius
  double relaxing_share;  // instantaneous over long-term force, minus one
  double relaxation_time_s;
  std::uint64_t nodes, triangles, skin, grid, columns, compliance;  // offsets from the block's start
};

// Read access; the block outlives it.
class SoftBodyView {
 public:
  explicit SoftBodyView(const std::byte* block) noexcept : block_(block) {}

  const SoftHeader& header() const noexcept { return *reinterpret_cast<const SoftHeader*>(block_); }
  const SoftNode& Node(std::uint32_t i) const noexcept { return At<SoftNode>(header().nodes)[i]; }
  const SoftTriangle& GetTriangle(std::uint32_t i) const noexcept { return At<SoftTriangle>(header().triangles)[i]; }
  const SoftSkin& Skin(std::uint32_t vertex) const noexcept { return At<SoftSkin>(header().skin)[vertex]; }
  std::uint32_t Seed(std::uint32_t cell) const noexcept { return At<std::uint32_t>(header().grid)[cell]; }
  // Displacement (m) of all nodes for 1 N pressed in at `node`, one after another.
  const Float3* Column(std::uint32_t node) const noexcept {
    return At<Float3>(header().columns) + static_cast<std::size_t>(node) * header().node_count;
  }
  // How far the patch at i goes in for 1 N on the patch at j, m/N; symmetric, positive definite.
  float Compliance(std::uint32_t i, std::uint32_t j) const noexcept {
    const std::size_t high = i > j ? i : j;
    const std::size_t low = i > j ? j : i;
    return At<float>(header().compliance)[high * (high + 1) / 2 + low];
  }

 private:
  template <class T>
  const T* At(std::uint64_t offset) const noexcept {
    return reinterpret_cast<const T*>(block_ + offset);
  }
  const std::byte* block_;
};

// Owns a checked block.
class SoftBody {
 public:
  // Checks magic, version, size, checksum, and that every index in it is in range; names what is wrong.
  static base::Result<SoftBody> Load(std::span<const std::byte> bytes);
  std::span<const std::byte> bytes() const noexcept { return block_; }
  SoftBodyView view() const noexcept { return SoftBodyView(block_.data()); }

 private:
  explicit SoftBody(std::vector<std::byte> block) : block_(std::move(block)) {}
  std::vector<std::byte> block_;
};

struct SoftParts {
  SoftHeader header{};
  std::vector<SoftNode> nodes;
  std::vector<SoftTriangle> triangles;
  std::vector<SoftSkin> skin;
  std::vector<std::uint32_t> grid;
  std::vector<Float3> columns;    // node_count x node_count
  std::vector<float> compliance;  // lower triangle
};

// Lays the parts out and fills in counts, offsets and the checksum.
std::vector<std::byte> LayOutSoftBody(const SoftParts& parts);

// FNV-1a over 64-bit words, continuing from `hash`.
std::uint64_t SoftHash(std::span<const std::byte> bytes, std::uint64_t hash = 0xCBF29CE484222325);

// The place on the coarse surface that is nearest to a point, from a hint or from the seed grid. Runs in the tick:
// local descent over the coarse triangles, at most 32 moves. `hint`: a triangle near by, or kNoSoftTriangle. A point
// that is not finite gives triangle 0.
SoftPlace LocateOnSoftBody(const SoftBodyView& body, const Vec3& point_base_m, std::uint32_t hint) noexcept;

}  // namespace omni::haptics
