// Other methods on one body: cylinder of 30 mm on 30 mm, the ball pressed into the middle of its top.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <numbers>

#include "service/haptics/deformable/soft_contact.h"
#include "tests/bench/deformable/corotational.h"
#include "tests/bench/deformable/projective.h"
#include "tests/bench/deformable/rows.h"

namespace omni::bench {
namespace {

constexpr double kPeerModulus_Pa = 2e5;

struct Task {
  AxisBody body;
  double ball_m = kBall_m;
  double depth_m = 0;
  double reference_N = 0;
};

Task MakeTask(const AxisBody& body, double ball_m, double depth_m, bool quick) {
  const AxisCurve curve = PressBall(body, kPoisson, ball_m, {depth_m}, {quick ? 4e-4 : 1e-4, 1.15});
  return {body, ball_m, depth_m, curve.force_per_modulus_m2[0] * kPeerModulus_Pa};
}

haptics::TetLattice StuffBody(const AxisBody& body, double tets) {
  const SurfaceMesh mesh = TurnBody(body, 96, 48);
  const double volume_m3 = std::numbers::pi * body.radius_m * body.radius_m * body.height_m;
  return haptics::StuffLattice(mesh.vertices, mesh.triangles, std::cbrt(12 * volume_m3 / tets), {0.137, 0.291, 0.419});
}

struct PeerRun {
  double us_median = 0, us_p99 = 0;
  double force_N = 0;     // at the end
  double change_pct = 0;  // of it in the last ticks
};

// Pressed in over `pressing` equal ticks, then at rest until the force is constant, at most `rest` ticks; all ticks are
// timed.
template <class Peer>
PeerRun Press(Peer& peer, const Task& task, int pressing, int rest) {
  std::vector<double> us, forces_N;
  for (int tick = 1; tick <= pressing + rest; ++tick) {
    const double depth_m = task.depth_m * std::min(1.0, static_cast<double>(tick) / pressing);
    const auto begin = std::chrono::steady_clock::now();
    forces_N.push_back(peer.Step({0, 0, task.body.height_m + task.ball_m - depth_m}));
    us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
    if (tick > pressing + 5 && std::abs(PercentOff(forces_N.back(), forces_N[forces_N.size() - 4])) < 0.02) break;
  }
  PeerRun run{0, 0, forces_N.back(), PercentOff(forces_N.back(), forces_N[forces_N.size() - 4])};
  std::sort(us.begin(), us.end());
  run.us_median = us[us.size() / 2];
  run.us_p99 = us[us.size() * 99 / 100];
  return run;
}

nlohmann::ordered_json PeerRow(const char* method, std::size_t tets, const Task& task, const PeerRun& run) {
  return {{"method", method},
          {"tets", tets},
          {"contact_nodes", 1},
          {"us_median", run.us_median},
          {"us_p99", run.us_p99},
          {"error_pct", std::abs(PercentOff(run.force_N, task.reference_N))},
          {"reference", "neo-Hookean, axisymmetric, " + task.body.name + " at 1.5 mm"}};
}

// Validates the peers: on a small body, where the lattice is finer than the contact, they must converge to the
// reference as it is refined; with the larger ball at small strains, where their materials are the reference's.
void AddConvergence(const Settings& settings, Rows& rows) {
  const AxisBody body{"cylinder r9 h9", 0.009, 0.009, 0};
  for (const Task& task : {MakeTask(body, kBall_m, 8e-4, settings.quick), MakeTask(body, 0.02, 2e-4, settings.quick)}) {
    const auto add = [&](const char* method, const haptics::TetLattice& lattice, const PeerRun& run) {
      rows.push_back({{"table", "peer convergence"},
                      {"method", method},
                      {"body", body.name},
                      {"ball_mm", 1e3 * task.ball_m},
                      {"depth_mm", 1e3 * task.depth_m},
                      {"tets", lattice.tets.size()},
                      {"cell_mm", 1e3 * lattice.cell_m},
                      {"force_N", run.force_N},
                      {"reference_N", task.reference_N},
                      {"error_pct", PercentOff(run.force_N, task.reference_N)},
                      {"still_moving_pct", run.change_pct}});
    };
    for (const double tets : {600.0, 5000.0, 40000.0}) {
      if (settings.quick && tets > 1000) break;
      const haptics::TetLattice lattice = StuffBody(body, tets);
      Corotational corotational(lattice, kPeerModulus_Pa, kPoisson, 1e-5, task.ball_m);
      add("study-corotational", lattice, Press(corotational, task, 8, 30));
      if (tets > 10000) continue;
      Projective projective(lattice, kPeerModulus_Pa, kPoisson, 1e-5, task.ball_m);
      add("study-projective", lattice, Press(projective, task, 8, 60));
    }
  }
}

}  // namespace

void AddPeers(const Settings& settings, Rows& rows) {
  const Task task = MakeTask({"cylinder r30 h30", 0.03, 0.03, 0}, kBall_m, 1.5e-3, settings.quick);
  for (const double tets : {500.0, 2000.0, 8000.0, 30000.0}) {
    if (settings.quick && tets > 500) break;
    const haptics::TetLattice lattice = StuffBody(task.body, tets);
    Corotational corotational(lattice, kPeerModulus_Pa, kPoisson, 1e-5, task.ball_m);
    rows.push_back(PeerRow("study-corotational", lattice.tets.size(), task, Press(corotational, task, 40, 40)));
    if (tets > 10000) continue;
    Projective projective(lattice, kPeerModulus_Pa, kPoisson, 1e-5, task.ball_m);
    rows.push_back(PeerRow("study-projective", lattice.tets.size(), task, Press(projective, task, 40, 60)));
  }
  // The module on the same task with other lattices; its time was taken before, in this order.
  const std::uint32_t* tets = kStudyTets;
  for (nlohmann::ordered_json& row : rows) {
    if (row.value("method", "") != "study-omni-tets" || row.value("contact_nodes", 0) != 1) continue;
    haptics::SoftBuildReport report;
    const haptics::SoftBody soft =
        MakeSoft(task.body, {kPeerModulus_Pa, kPoisson, 1}, {0, 0, 1}, *tets++, settings.seed, report);
    row["error_pct"] = std::abs(PercentOff(ForceAt(soft, task.body, {}, task.depth_m), task.reference_N));
    row["reference"] = "neo-Hookean, axisymmetric, " + task.body.name + " at 1.5 mm";
  }
  AddConvergence(settings, rows);
}

}  // namespace omni::bench
