// Fig. 5: net vertical force at 5 A on a magnet that rests on the sphere, against the magnet's size. The text gives no
// numbers except that its magnet is at the maximum among magnets of similar volume.
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "tests/bench/paper/paper.h"
#include "tests/bench/paper/paper_force_models.h"

namespace omni::bench {
namespace {

constexpr double kCurrent_A = 5;
constexpr double kDensity_kg_m3 = 7600;  // NdFeB: 37.6 g of the S-30-07-N
constexpr double kGravity_m_s2 = 9.81;
constexpr int kSteps = 21;
constexpr double kRadiusLow_m = 0.005, kRadiusStep_m = 1e-3;
constexpr double kHeightLow_m = 0.001, kHeightStep_m = 1e-3;

enum class Model { kLaw, kTwin, kOurs };

// Push of coil z less weight and the core's pull; the magnet's face touches the hull.
double NetForce_N(base::DeviceGeometry device, double radius_m, double height_m, Model model) {
  device.magnet.radius_m = radius_m;
  device.magnet.half_height_m = height_m / 2;
  const double d = device.hull_radius_m + height_m / 2;
  const ForceTable forces = model == Model::kLaw    ? PaperLawForces(device, d)
                            : model == Model::kTwin ? TwinForces(device, d, device.core_kappa)
                                                    : OurForces(device, d, device.core_kappa);
  const double weight_N = kDensity_kg_m3 * std::numbers::pi * radius_m * radius_m * height_m * kGravity_m_s2;
  return kCurrent_A * forces.radial_z_N_A - forces.snapping_N - weight_N;
}

struct Sweep {
  std::vector<double> force_N;  // radius-major
  double best_N = -1e9, best_radius_m = 0, best_height_m = 0;
  double best_of_volume_N = -1e9, volume_radius_m = 0, volume_height_m = 0;  // of the paper's volume
};

Sweep SweepSizes(const base::DeviceGeometry& device, Model model) {
  Sweep sweep;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      const double radius_m = kRadiusLow_m + kRadiusStep_m * i, height_m = kHeightLow_m + kHeightStep_m * j;
      const double force_N = NetForce_N(device, radius_m, height_m, model);
      sweep.force_N.push_back(force_N);
      if (force_N > sweep.best_N) {
        sweep.best_N = force_N, sweep.best_radius_m = radius_m, sweep.best_height_m = height_m;
      }
    }
  }
  // The same volume as the paper's magnet, wider or taller.
  const double shape_m3 = device.magnet.radius_m * device.magnet.radius_m * 2 * device.magnet.half_height_m;
  constexpr int kShapes = 35;
  for (int i = 0; i < kShapes; ++i) {
    const double radius_m = 0.008 + 5e-4 * i;
    const double height_m = shape_m3 / (radius_m * radius_m);
    const double force_N = NetForce_N(device, radius_m, height_m, model);
    if (force_N > sweep.best_of_volume_N) {
      sweep.best_of_volume_N = force_N, sweep.volume_radius_m = radius_m, sweep.volume_height_m = height_m;
    }
  }
  return sweep;
}

// Data of the figure: the lift of every size, and the size of the paper's magnet.
void AddSizes(const base::DeviceGeometry& device, const Sweep& law, const Sweep& twin, const Sweep& ours,
              BenchRows& rows) {
  rows.push_back({{"table", "magnet of the paper"},
                  {"radius_mm", 1e3 * device.magnet.radius_m},
                  {"height_mm", 2e3 * device.magnet.half_height_m}});
  for (std::size_t i = 0; i < law.force_N.size(); ++i) {
    const std::size_t radius = i / kSteps, height = i % kSteps;
    rows.push_back({{"table", "magnet sizes"},
                    {"radius_mm", 1e3 * (kRadiusLow_m + kRadiusStep_m * static_cast<double>(radius))},
                    {"height_mm", 1e3 * (kHeightLow_m + kHeightStep_m * static_cast<double>(height))},
                    {"paper_law_N", law.force_N[i]},
                    {"twin_N", twin.force_N[i]},
                    {"ours_N", ours.force_N[i]}});
  }
}

void AddRow(const char* name, const base::DeviceGeometry& device, const Sweep& sweep, Model model, BenchRows& rows) {
  const double radius_m = device.magnet.radius_m, height_m = 2 * device.magnet.half_height_m;
  const double here_N = NetForce_N(device, radius_m, height_m, model);
  rows.push_back({{"model", name},
                  {"net_force_paper_magnet_N", here_N},
                  {"best_of_same_volume_N", sweep.best_of_volume_N},
                  {"its_radius_mm", 1e3 * sweep.volume_radius_m},
                  {"its_height_mm", 1e3 * sweep.volume_height_m},
                  {"paper_magnet_pct_of_it", 100 * here_N / sweep.best_of_volume_N},
                  {"best_of_all_N", sweep.best_N},
                  {"at_radius_mm", 1e3 * sweep.best_radius_m},
                  {"at_height_mm", 1e3 * sweep.best_height_m}});
}

}  // namespace

PaperSection PaperMagnets(const base::DeviceGeometry& device) {
  PaperSection section{.title = "Size of the magnet, net lift at 5 A in coil z on top of the sphere (Fig. 5)"};
  const Sweep law = SweepSizes(device, Model::kLaw);
  const Sweep twin = SweepSizes(device, Model::kTwin);
  const Sweep ours = SweepSizes(device, Model::kOurs);
  AddRow("paper's law (no core's pull)", device, law, Model::kLaw, section.rows);
  AddRow("twin", device, twin, Model::kTwin, section.rows);
  AddRow("ours", device, ours, Model::kOurs, section.rows);
  section.notes = {
      "no free parameter; contact on the hull, remanence of the drawing, 7600 kg/m^3; radius 5-25 mm, height 1-21 mm",
      "the text: \"15 mm diameter x 7 mm, 5 cm^3\" (radius 15 mm), at the maximum among magnets of similar volume; a "
      "bigger one may be worse, since its weight counteracts",
      "the dipole law overestimates wide magnets: their rim is further away; the twin adds the core's pull, which "
      "grows "
      "with the square of the moment"};
  AddSizes(device, law, twin, ours, section.rows);
  return section;
}

}  // namespace omni::bench
