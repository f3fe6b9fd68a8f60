#include <algorithm>
#include <chrono>
#include <cmath>

#include "tests/bench/deformable/corotational.h"
#include "tests/bench/deformable/rows.h"

namespace omni::bench {

// The ball goes to 1.5 mm in 150 ticks and rests there for 50; the force at the end is judged, as that of the others.
void AddPeers(const Settings& settings, Rows& rows) {
  constexpr double kDepth_m = 1.5e-3;
  constexpr int kTicks = 200;
  const AxisBody body{"cylinder r30 h30", 0.03, 0.03, 0};
  const AxisCurve curve = PressBall(body, kPoisson, kBall_m, {kDepth_m}, {settings.quick ? 4e-4 : 1e-4, 1.15});
  const double reference_N = curve.force_per_modulus_m2[0] * 2e5;
  const SurfaceMesh mesh = TurnBody(body, 96, 48);
  for (const std::uint32_t tets : {500U, 2000U, 8000U}) {
    if (settings.quick && tets > 500) break;
    const auto lattice =
        haptics::BuildTetLattice(mesh.vertices, mesh.triangles, {.max_tets = tets, .max_surface_vertices = 1024});
    if (!lattice.ok()) continue;
    Corotational peer(*lattice, 2e5, kPoisson, 1e-5);
    std::vector<double> us;
    double force_N = 0;
    for (int tick = 1; tick <= kTicks; ++tick) {
      const double depth_m = kDepth_m * std::min(1.0, tick / 150.0);
      const auto begin = std::chrono::steady_clock::now();
      force_N = peer.Step({0, 0, body.height_m + kBall_m - depth_m}, kBall_m);
      us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    }
    std::sort(us.begin(), us.end());
    rows.push_back({{"method", "study-corotational"},
                    {"tets", peer.tets()},
                    {"contact_nodes", 1},
                    {"us_median", us[us.size() / 2]},
                    {"us_p99", us[us.size() * 99 / 100]},
                    {"error_pct", 100 * std::abs(force_N / reference_N - 1)},
                    {"reference", "neo-Hookean, axisymmetric, cylinder r30 h30 at 1.5 mm"}});
  }
}

}  // namespace omni::bench
