#include "tests/bench/paper/paper_force_models.h"

#include <cmath>
#include <vector>

#include "service/actuation/force_map.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/nominal.h"
#include "service/sim/fields/truth_model.h"
#include "tests/bench/peers/paper_method.h"

namespace omni::bench {
namespace {

using base::Vec3;

constexpr Vec3 kUnits[] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};

// `force(direction, coil, along)`: component of coil's force per ampere along `along`, magnet on the axis `direction`.
template <class F>
ForceTable Tabulate(const F& force) {
  ForceTable table;
  table.radial_x_N_A = std::abs(force(0, 0, 0));
  table.radial_y_N_A = std::abs(force(1, 1, 1));
  table.radial_z_N_A = std::abs(force(2, 2, 2));
  table.tangential_x_N_A = std::abs(force(2, 0, 0));
  table.tangential_y_N_A = std::abs(force(2, 1, 1));
  return table;
}

}  // namespace

ForceTable TwinForces(const base::DeviceGeometry& device, double distance_m, double kappa) {
  base::DeviceGeometry changed = device;
  changed.core_kappa = kappa;
  sim::TruthModel truth(changed, {}, false);
  const auto at = [&](std::size_t direction) {
    return truth.ForcesAt({distance_m * kUnits[direction], -1.0 * kUnits[direction]});
  };
  const sim::ForceMap maps[] = {at(0), at(1), at(2)};
  ForceTable table = Tabulate([&](std::size_t direction, std::size_t coil, std::size_t along) {
    return Dot(maps[direction].coil[coil].force_N, kUnits[along]);
  });
  table.snapping_N = -maps[2].core.force_N.z;
  return table;
}

ForceTable OurForces(const base::DeviceGeometry& device, double distance_m, double kappa) {
  base::DeviceGeometry changed = device;
  changed.core_kappa = kappa;
  const actuation::ForceMap map = actuation::MakeForceMap(changed);
  const auto at = [&](std::size_t direction) {
    return actuation::EvaluateForceMap(map, distance_m * kUnits[direction], -1.0 * kUnits[direction]);
  };
  const actuation::ForceAtPose forces[] = {at(0), at(1), at(2)};
  ForceTable table = Tabulate([&](std::size_t direction, std::size_t coil, std::size_t along) {
    return forces[direction].newton_per_ampere[3 * along + coil];
  });
  table.snapping_N = -forces[2].snapping_N.z;
  return table;
}

ForceTable PaperLawForces(const base::DeviceGeometry& device, double distance_m) {
  const base::Calibration drawn = magnetics::NominalCalibration(device);
  std::vector<Vec3> sweep(3 * drawn.sensors.size());
  for (std::size_t i = 0; i < drawn.sensors.size(); ++i) {
    const auto& map = drawn.sensors[i].current_map_T_A;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) sweep[3 * i + k] = {map[k], map[3 + k], map[6 + k]};
  }
  const peers::PaperModel model = peers::MakePaperModel(drawn, sweep);
  const double per_moment = 3 * magnetics::kMu0Over4Pi * model.moment_Am2 / std::pow(distance_m, 4);
  const auto& C = model.moment_per_ampere_Am2_A;
  return {.radial_x_N_A = 2 * per_moment * C[0],
          .radial_y_N_A = 2 * per_moment * C[4],
          .radial_z_N_A = 2 * per_moment * C[8],
          .tangential_x_N_A = per_moment * C[0],
          .tangential_y_N_A = per_moment * C[4]};
}

}  // namespace omni::bench
