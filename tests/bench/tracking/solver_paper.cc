// The paper's own method among the solvers: dipoles, angles, L-BFGS, on raw readings.
#include <memory>

#include "service/base/eigen.h"
#include "tests/bench/peers/paper_method.h"
#include "tests/bench/tracking/solver.h"

namespace omni::bench {
namespace {

// Sensors' readings per ampere, from the calibration's maps.
std::vector<base::Vec3> SweepOf(const base::Calibration& calibration) {
  std::vector<base::Vec3> sweep;
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    const auto& map = sensor.current_map_T_A;
    for (std::size_t k = 0; k < base::kCoilCount; ++k) sweep.push_back({map[k], map[3 + k], map[6 + k]});
  }
  return sweep;
}

}  // namespace

std::vector<SolverMethod> PaperSolvers(const base::Calibration& calibration) {
  const auto solver = std::make_shared<peers::PaperSolver>(peers::MakePaperModel(calibration, SweepOf(calibration)));
  std::vector<SolverMethod> methods;
  for (const bool warm : {true, false}) {
    methods.push_back(
        {.method = "ceres-lbfgs",
         .model = "paper-dipole",
         .start = warm ? "warm" : "cold",
         .precision = "double",
         .variant = warm ? "lbfgs" : "lbfgs, nine starts",
         .solve = [solver, warm](const SolverCase& one) -> std::optional<SolverAnswer> {
           const peers::PaperScan scan{one.scan.field_sensor_T, one.scan.saturated_mask, one.scan.coil_current_A};
           const peers::PaperPose start =
               peers::PoseOf(base::FromEigen(one.warm.position_base_m), base::FromEigen(one.warm.axis_base));
           const peers::PaperFit fit = warm ? solver->Solve(scan, start) : solver->SolveCold(scan);
           return SolverAnswer{fit.pose.position_base_m, peers::AxisOf(fit.pose)};
         }});
  }
  return methods;
}

}  // namespace omni::bench
