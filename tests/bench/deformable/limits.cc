// Cases with exact solutions: small contacts are Hertz's, far displacements Boussinesq's, and a rotation of a body of
// revolution changes nothing.
#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "service/haptics/deformable/build/fem.h"
#include "tests/bench/deformable/rows.h"

namespace omni::bench {
namespace {

using haptics::Vec3;

constexpr double kLimitModulus_Pa = 2e5;

void AddHertz(const Settings& settings, std::uint32_t tets, Rows& rows) {
  const AxisBody block{"block r60 h60", 0.06, 0.06, 0};
  std::mt19937_64 rng(settings.seed + 11);
  for (int trial = 0; trial < (settings.quick ? 1 : 2); ++trial) {
    haptics::SoftBuildReport report;
    const haptics::SoftBody soft = MakeSoft(block, {kLimitModulus_Pa, kPoisson, 1}, {0, 0, 1}, tets, rng(), report);
    const Place place = trial == 0 ? Place{} : DrawPlace({"", 0.03, 0.06, 0}, rng);
    for (const double a_over_r : {0.02, 0.05, 0.1}) {
      const double depth_m = a_over_r * a_over_r * kBall_m;
      rows.push_back({{"table", "hertz"},
                      {"body", block.name},
                      {"aside_mm", 1e3 * place.aside_m},
                      {"a_over_R", a_over_r},
                      {"error_pct",
                       PercentOff(ForceAt(soft, block, place, depth_m), HertzPerModulus(depth_m) * kLimitModulus_Pa)}});
    }
  }
}

// Displacement of a half-space z < 0 by 1 N pressed into it at the origin   [Johnson, Contact Mechanics, 3.19]
Vec3 Boussinesq(const Vec3& p) {
  const double shear_Pa = kLimitModulus_Pa / (2 * (1 + kPoisson));
  const double distance = Norm(p);
  const double down = -p.z;
  const double scale = 1 / (4 * std::numbers::pi * shear_Pa * distance);
  const double aside = scale * (down / (distance * distance) - (1 - 2 * kPoisson) / (distance + down));
  return {aside * p.x, aside * p.y, -scale * (down * down / (distance * distance) + 2 * (1 - kPoisson))};
}

// A lattice cut out of a half-space: everything but its flat top is held at Boussinesq's displacement.
class HalfSpacePiece {
 public:
  HalfSpacePiece(const haptics::TetLattice& lattice, double top_m)
      : mesh_(haptics::MakeQuadratic(lattice)), cell_m_(lattice.cell_m) {
    held_.assign(mesh_.nodes_base_m.size(), false);
    for (const auto& t : mesh_.surface) {
      const bool on_top = std::all_of(
          t.begin(), t.end(), [&](std::uint32_t n) { return mesh_.nodes_base_m[n].z > top_m - 1e-3 * cell_m_; });
      for (const std::uint32_t n : t) held_[n] = held_[n] || !on_top;
    }
    double nearest = 1;
    for (const auto& t : mesh_.surface) {
      for (std::size_t k = 0; k < 3; ++k) {
        const Vec3& p = mesh_.nodes_base_m[t[k]];
        if (held_[t[k]] || !(p.x * p.x + p.y * p.y < nearest)) continue;
        nearest = p.x * p.x + p.y * p.y;
        loaded_ = t[k];
      }
    }
  }

  // Error of the displacement along the normal at the top's free nodes, by distance in cells; the worst one of each.
  struct Ring {
    double worst_pct = 0;
    int nodes = 0;
  };
  std::map<int, Ring> Judge() const {
    const auto stiffness = haptics::MakeStiffness({kLimitModulus_Pa, kPoisson, 1}, {0, 0, 1});
    const auto fem = haptics::ElasticFem::Build(
        mesh_, [&](const Vec3&) { return stiffness; }, held_);
    std::map<int, Ring> rings;
    if (!fem.ok()) return rings;
    haptics::LoadBlock block(3 * mesh_.nodes_base_m.size());
    AddHeld(stiffness, block);
    const auto patch = haptics::MeasurePatches(mesh_, {loaded_}, 1.7 * cell_m_)[0];
    for (const auto& [node, share] : haptics::SpreadLoad(mesh_, patch, 1.25 * cell_m_).shares)
      block[3 * node + 2][0] -= share;
    fem->Solve(block);
    std::vector<bool> seen = held_;
    for (const auto& t : mesh_.surface) {
      for (const std::uint32_t n : t) {
        if (seen[n]) continue;
        seen[n] = true;
        const Vec3 away = mesh_.nodes_base_m[n] - mesh_.nodes_base_m[loaded_];
        if (Norm(away) < cell_m_) continue;
        Ring& ring = rings[static_cast<int>(Norm(away) / cell_m_)];
        ++ring.nodes;
        ring.worst_pct = std::max(ring.worst_pct, std::abs(PercentOff(block[3 * n + 2][0], Boussinesq(away).z)));
      }
    }
    return rings;
  }
  double cell_m() const { return cell_m_; }

 private:
  // f = - K_free,held u_held
  void AddHeld(const haptics::Stiffness6& stiffness, haptics::LoadBlock& block) const {
    for (const auto& tet : mesh_.tets) {
      if (std::none_of(tet.begin(), tet.end(), [&](std::uint32_t n) { return held_[n]; })) continue;
      const auto k = haptics::ElementStiffness({mesh_.nodes_base_m[tet[0]], mesh_.nodes_base_m[tet[1]],
                                                mesh_.nodes_base_m[tet[2]], mesh_.nodes_base_m[tet[3]]},
                                               stiffness);
      for (std::size_t b = 0; b < 10; ++b) {
        if (!held_[tet[b]]) continue;
        const Vec3 u = Boussinesq(mesh_.nodes_base_m[tet[b]] - mesh_.nodes_base_m[loaded_]);
        for (std::size_t row = 0; row < 30; ++row) {
          const double* entry = &k[30 * row + 3 * b];
          if (!held_[tet[row / 3]])
            block[3 * tet[row / 3] + row % 3][0] -= entry[0] * u.x + entry[1] * u.y + entry[2] * u.z;
        }
      }
    }
  }

  haptics::QuadraticMesh mesh_;
  double cell_m_;
  std::vector<bool> held_;
  std::uint32_t loaded_ = 0;
};

void AddBoussinesq(std::uint32_t tets, Rows& rows) {
  const AxisBody plate{"plate r60 h30", 0.06, 0.03, 0};
  const SurfaceMesh mesh = TurnBody(plate, 96, 48);
  const auto lattice = haptics::BuildTetLattice(mesh.vertices, mesh.triangles, {.max_tets = tets});
  if (!lattice.ok()) return;
  const HalfSpacePiece piece(*lattice, plate.height_m);
  for (const auto& [cells, ring] : piece.Judge()) {
    rows.push_back({{"table", "boussinesq"},
                    {"tets", lattice->tets.size()},
                    {"cell_mm", 1e3 * piece.cell_m()},
                    {"distance_cells", std::to_string(cells) + " to " + std::to_string(cells + 1)},
                    {"nodes", ring.nodes},
                    {"worst_pct", ring.worst_pct}});
  }
}

// Fibre and ball turn together about the axis of a body of revolution, but its lattice does not: nothing may change.
void AddFibre(const Settings& settings, std::uint32_t tets, Rows& rows) {
  const AxisBody round{"cylinder r30 h30", 0.03, 0.03, 0};
  for (const double tilt : {0.0, 0.7}) {
    double first_N = 0;
    for (int turn = 0; turn < (settings.quick ? 2 : 5); ++turn) {
      const double angle = turn * std::numbers::pi / 8;
      haptics::SoftBuildReport report;
      const haptics::SoftBody soft =
          MakeSoft(round, {kLimitModulus_Pa, kPoisson, 4},
                   {std::cos(angle) * std::cos(tilt), std::sin(angle) * std::cos(tilt), std::sin(tilt)}, tets,
                   settings.seed, report);
      const double force_N = ForceAt(soft, round, {0.011, angle + 0.5}, 1e-3);
      if (turn == 0) first_N = force_N;
      rows.push_back({{"table", "fibre turned"},
                      {"fibre_ratio", 4},
                      {"tilt_deg", tilt * 180 / std::numbers::pi},
                      {"angle_deg", 22.5 * turn},
                      {"aside_mm", 11},
                      {"force_N", force_N},
                      {"off_first_pct", PercentOff(force_N, first_N)}});
    }
  }
}

}  // namespace

void AddLimits(const Settings& settings, Rows& rows) {
  const std::uint32_t tets = settings.quick ? 600 : settings.shipped_tets;
  AddHertz(settings, tets, rows);
  AddBoussinesq(tets, rows);
  AddFibre(settings, tets, rows);
}

}  // namespace omni::bench
