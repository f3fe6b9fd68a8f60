// Parts of omni_bench_deformable; each adds flat rows, side tables by their key "table".
#pragma once

#include <cstdint>
#include <vector>

#include <nlohmann/json.hpp>

#include "service/haptics/deformable/build_soft_body.h"
#include "tests/bench/deformable/axis_mesh.h"

namespace omni::bench {

using Rows = std::vector<nlohmann::ordered_json>;

struct Settings {
  std::uint64_t seed = 1;
  bool quick = false;
  std::uint32_t shipped_tets = haptics::SoftBodyOptions{}.lattice.max_tets;
};

inline constexpr double kBall_m = 0.005;
inline constexpr double kPoisson = 0.4;

// Force of `omni` against the neo-Hookean reference, and what Hertz's law or the body without gain would give.
void AddAccuracy(const Settings& settings, Rows& rows);
// The reference against itself on finer meshes; the gain of soft_gain.h against a fresh fit.
void AddReferenceTables(const Settings& settings, Rows& rows);
// A tick with 1, 4 and 16 balls, by tetrahedra; time and memory to prepare.
void AddTiming(const Settings& settings, Rows& rows);
// Small contacts against Hertz, and forces while the fibre turns about the ball's axis.
void AddLimits(const Settings& settings, Rows& rows);

// Co-rotational elements on the same lattices.
void AddPeers(const Settings& settings, Rows& rows);

// A body of revolution made soft, clamped at z = 0, without relaxation.
haptics::SoftBody MakeSoft(const AxisBody& body, const haptics::ElasticModuli& moduli, const haptics::Vec3& fibre,
                           std::uint32_t tets, std::uint64_t seed, haptics::SoftBuildReport& report);

// Long-term force at the top of the axis.
double ForceAtTop(const haptics::SoftBody& soft, const AxisBody& body, double depth_m);

}  // namespace omni::bench
