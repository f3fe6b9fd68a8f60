// Parts of omni_bench_deformable; each adds flat rows, side tables by their key "table".
#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include "tests/bench/deformable/bodies.h"

namespace omni::bench {

using Rows = std::vector<nlohmann::ordered_json>;

struct Settings {
  std::uint64_t seed = 1;
  bool quick = false;
  std::uint32_t shipped_tets = haptics::SoftBodyOptions{}.lattice.max_tets;
};

// Lattices besides the shipped one.
inline constexpr std::uint32_t kStudyTets[] = {600, 4000};

// Force of `omni` against the neo-Hookean references, on and off the axis, at both moduli; also by Hertz's law alone.
void AddAccuracy(const Settings& settings, Rows& rows);
// The references against finer meshes, against each other, and the gain of local_model.h against a fresh fit.
void AddReferenceTables(const Settings& settings, Rows& rows);
// A tick with 1, 4 and 16 balls, by tetrahedra; time and memory to prepare.
void AddTiming(const Settings& settings, Rows& rows);
// Small contacts against Hertz, far displacements against Boussinesq, and forces while the fibre turns.
void AddLimits(const Settings& settings, Rows& rows);
// Co-rotational elements and projective dynamics on the same body.
void AddPeers(const Settings& settings, Rows& rows);

}  // namespace omni::bench
