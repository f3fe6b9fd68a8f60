// The benchmarks of omni-bench. Each returns rows (service/tools/common/row_table.h).
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "service/base/result.h"
#include "service/tools/common/row_table.h"

namespace omni::bench {

using BenchRows = tools::Rows;

struct BenchOptions {
  std::uint64_t ticks = 0;  // loop: per scene; stress: in all; 0: the bench's own number
  std::uint64_t seed = 1;
  bool quick = false;             // much less work, to check that it runs
  std::uint64_t cold_solves = 0;  // solver: cold starts to search for failures; 0: the bench's own number
  std::string mesh;               // collision: a .glb file instead of the bench's own bodies
  double hours = 10;              // stress: virtual time of the drift run
  std::string conditions;         // room: only these, separated by commas; empty: all
  std::uint64_t bases = 0;        // numbers: 0: the bench's own number
  std::string numbers;            // numbers: only these, separated by commas; empty: all
  double factor = 0;              // numbers: scaled by it and its inverse; 0: by .7 and 1.4
  std::string resume;             // numbers: file with what is done; empty: none
};

// Benches that draw rigs and poses use three seeds; the same --seed gives the same ones.
inline std::vector<std::uint64_t> ThreeSeeds(std::uint64_t seed) {
  return {1000 * seed + 1, 1000 * seed + 2, 1000 * seed + 3};
}

// Tick alone, per shipped scene: scene, ticks, us_median, us_p99, us_max, allocations, late_ticks.
base::Result<BenchRows> BenchLoop(const BenchOptions& options);

// The whole tick in demanding scenes: scene, triangles, us_median, us_p99, allocations; side tables: cost of each
// feature of a material, and lateness of ticks beside two busy threads.
base::Result<BenchRows> BenchTick(const BenchOptions& options);
// Loading, each file in a fresh process: scene, tagged, bytes_file, bytes_read (by the system), images_decoded,
// threads, rss_MB (both beyond the process before), load_ms, build_ms, cached.
base::Result<BenchRows> BenchScene(const BenchOptions& options);

// Calls through the layer over the in-repo runtime: call, ns_median, ns_p99, syscalls.
base::Result<BenchRows> BenchIpc(const BenchOptions& options);

// The layer: call, method, horizon_ms, ns_median, error_mm_p95 (calls with and without it; predicted and held poses).
// Side tables: cost, latency, memory, library, motions.
base::Result<BenchRows> BenchLayer(const BenchOptions& options);

// Force map against the twin, by model and gap; timing: model, gap_mm, error_median_pct, ..., stage, us_median, us_p99.
base::Result<BenchRows> BenchForce(const BenchOptions& options);

// The vector kernels by instruction set: part, instructions, precision, us_median, us_p99.
base::Result<BenchRows> BenchKernels(const BenchOptions& options);

// Heat runs of the paper on the twin and in the host: run, model, peak_C, peak_s, end_C, copper_peak_C, ... Side
// table: fifteen minutes of a constant set-point on the whole twin.
base::Result<BenchRows> BenchThermal(const BenchOptions& options);

// Per base: rig, seed, before_mm, raw_mm, aligned_mm, systematic_mm, seconds and more; then mean and worst.
// Side tables: the whole of `omni calibrate` with a moving pen, and in a room; our bundle adjustment beside that of
// Ceres.
base::Result<BenchRows> BenchCalibration(const BenchOptions& options);

// Simulated people align bases: method, n, noise_mm, error_mm_median, error_mm_p95, error_deg, predicted_mm, refused
// ...
base::Result<BenchRows> BenchAlign(const BenchOptions& options);

// Latency budget from a sample to the current that responds to it: stage, mean_us, late_us, what; side table: the
// stiffness that it allows.
base::Result<BenchRows> BenchLatency(const BenchOptions& options);

// Trackers' error against the twin, per model, noise and currents; side tables: Cramer-Rao bound by radius, hidden
// currents.
base::Result<BenchRows> BenchTracking(const BenchOptions& options);

// Effect of each number of the tracker's options: number, factor, error_change_pct, sigma_change_pct, posed_change,
// silent_change, reports_changed, no_effect; each the greatest over bases and rooms.
base::Result<BenchRows> BenchNumbers(const BenchOptions& options);

// Tracking outside a laboratory: condition, force, rigs, ticks, seed, tracked_fraction, coarse_fraction, mean_mm,
// p95_mm, sigma_mm, silent_fraction, pushed_silent_fraction (under force: silent, and a force was requested),
// worst_rig_mm (of a base's mean error over all its poses), recovery_ms_p95, force_error_p50_pct, force_error_p95_pct,
// limited_fraction (of ticks with a force, those whose force was cut); null where nothing was tracked. The last
// condition, pairs: two of them at random.
base::Result<BenchRows> BenchRoom(const BenchOptions& options);

// A pen that starts, stops, trembles and rests: room, motion, radius_mm, trials, p95_mm, max_mm (of each trial's worst
// tick), peak_speed_median_m_s, peak_speed_p95_m_s, gain, delay_ms (of the tremor), scatter_mm (rms about the mean of a
// second), nees_per_dof, lost_ticks.
base::Result<BenchRows> BenchDynamics(const BenchOptions& options);

// Run time and error of solvers on the same poses; side table: ratios.
base::Result<BenchRows> BenchSolver(const BenchOptions& options);

// Walls that a simulated hand presses: stiffness, delay, hand and noise against limit cycles, energy and buzz; side
// table: the stiffness allowed, by delay and noise.
base::Result<BenchRows> BenchStability(const BenchOptions& options);

// Ordinary hands on walls and constraints, on the twin in a room: motion, touched, runs, lost (under half of the
// stiffness before, half a second later, still touching), softened, least_share (of that stiffness); side table: the
// lost ones.
base::Result<BenchRows> BenchHands(const BenchOptions& options);

// Friction against Coulomb's law: study, body, trials, breakaway and sliding error; side tables: stick-slip, drift.
base::Result<BenchRows> BenchFriction(const BenchOptions& options);

// Gratings stroked on the twin in a room: wavelength_mm, speed_mm_s (mean; the peak is 1.9 times that), friction,
// in_band, correlation, rest_mN, plain_rest_mN (without a grating), delivered_mN: tests/support/touch/stroked_plate.h.
base::Result<BenchRows> BenchTexture(const BenchOptions& options);

// A point and balls stroke thirty bodies in six styles, judged by sums over all triangles
// (tests/support/touch/ball_judge.h): tip, radius_mm, body, style, ticks, inside, inverted, missed, false_contacts,
// through, us_median, us_p99; of fine meshes only times, of the point and the pen's ball in turns.
base::Result<BenchRows> BenchTips(const BenchOptions& options);
// Strokes over bodies whose meshes are broken, judged by the formulas of the whole bodies: body, defect, strokes, path
// (point or ball), ticks (judged ones: not beside openings wider than 50 um), inside, missed, false_contacts.
base::Result<BenchRows> BenchSides(const BenchOptions& options);

// Bad input into Tick, basins, singular poses, long runs: what must never happen, counted.
base::Result<BenchRows> BenchStress(const BenchOptions& options);

// Contact with rigid meshes, ours beside Embree, Bullet, FCL and CGAL: engine, mesh, triangles, us_median, us_p99,
// us_p999, build_ms, bytes_per_triangle, missed, false_contacts, direction_p99_deg, n. Side tables: build phases and
// bytes, correctness by path, times by path, ratios.
base::Result<BenchRows> BenchCollision(const BenchOptions& options);

// The race: commanded and rendered force per seed and impact speed of the shipped car; side tables: walls, cost.
base::Result<BenchRows> BenchRace(const BenchOptions& options);

// Soft bodies against a neo-Hookean reference: method, tets, contact_nodes, us_median, us_p99, error_pct, reference.
// Side tables: every point, time to prepare, the reference's mesh, the gain's fit, Hertz, turned fibres.
base::Result<BenchRows> BenchDeformable(const BenchOptions& options);

// Strokes on bodies of 10k to 870k triangles: triangles, radius_mm, publish_us_median, publish_us_p99 and more; side
// tables: cost in the tick, ten thousand strokes and all of them undone, force steps while editing under the tip.
base::Result<BenchRows> BenchSculpt(const BenchOptions& options);

// Displaying changing surfaces of 100,000 vertices: step, vertices, triangles, us_median, us_p99, n.
base::Result<BenchRows> BenchSurfaces(const BenchOptions& options);

}  // namespace omni::bench
