// From a triangle mesh to a soft body: lattice, finite elements, one solve per surface node. Seconds to minutes; meant
// for a thread of its own. docs/theory/deformable.md, section 4.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <span>

#include "service/base/result.h"
#include "service/haptics/deformable/build/elasticity.h"
#include "service/haptics/deformable/build/lattice.h"
#include "service/haptics/deformable/soft_body.h"

namespace omni::haptics {

struct SoftBodyOptions {
  ElasticModuli moduli;
  Vec3 fibre{0, 0, 1};  // direction of moduli.fibre_ratio everywhere, unless there is a field
  // Fibre at a point; not part of input_hash: give it a name in `fibre_field_id`.
  std::function<Vec3(const Vec3& point_base_m)> fibre_field;
  std::uint64_t fibre_field_id = 0;
  LatticeOptions lattice{.max_tets = 2000, .max_surface_vertices = 1000};
  double clamped_share = 0.05;     // of the height: what lies lower is held; (0, 0.9]. Down is -z.
  double hardening = 0;            // [0, 20]
  double relaxing_share = 0.3;     // [0, 5]
  double relaxation_time_s = 0.1;  // [0, 100]; 0: no relaxation
  // Called now and then with 0 ... 1; false: stop, with the error "cancelled".
  std::function<bool(double done)> progress;
};

// What it took, for people.
struct SoftBuildReport {
  std::uint32_t tets = 0, nodes = 0, surface_nodes = 0;
  double lattice_ms = 0, factor_ms = 0, columns_ms = 0;
  std::size_t bytes = 0;
};

// Equal input, equal hash; the key of a cache.
std::uint64_t SoftBodyKey(std::span<const Vec3> vertices_base_m,
                          std::span<const std::array<std::uint32_t, 3>> triangles, const SoftBodyOptions& options);

// Errors name the limit: moduli, nothing inside the mesh, nothing clamped, too few nodes, cancelled.
base::Result<SoftBody> BuildSoftBody(std::span<const Vec3> vertices_base_m,
                                     std::span<const std::array<std::uint32_t, 3>> triangles,
                                     const SoftBodyOptions& options, SoftBuildReport& report);

}  // namespace omni::haptics
