// The tracking method of Langerak et al., Omni (UIST 2020), Eq. 1-5, as it is published: magnet and electromagnet are
// dipoles, the pose is (x, y, z, theta, phi), L-BFGS minimises the weighted squared residuals. PyTorch's L-BFGS is
// replaced by that of Ceres (GradientProblem, line search), its auto-grad by the analytic gradient.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::peers {

struct PaperModel {
  std::vector<base::Vec3> sensor_position_base_m;
  std::vector<std::array<double, 9>> orientation_sensor_base;  // row-major, nominal R_SB
  double moment_Am2 = 0;                                       // Br V / mu0, Eq. 2
  std::array<double, 9> moment_per_ampere_Am2_A{};             // C of Eq. 3, row-major
};

// Data of the method: nominal sensors, moment from the data sheet, and C from a sweep of the currents without the pen:
// `sweep_T_A[3 i + k]` is the reading of sensor i (its own frame) per ampere in coil k. C is the least-squares fit of a
// dipole at the origin to each coil's readings.
PaperModel MakePaperModel(const base::Calibration& drawn, std::span<const base::Vec3> sweep_T_A);

struct PaperScan {
  std::span<const base::Vec3> field_sensor_T;
  std::uint64_t saturated_mask = 0;  // bit 3 i + axis: weight w = 0 in Eq. 5; the first 21 sensors
  std::array<double, base::kCoilCount> current_A{};
};

struct PaperPose {
  base::Vec3 position_base_m{0, 0, 0.065};
  double theta_rad = 3.141592653589793;  // of the moment, from +z
  double phi_rad = 0;                    // about +z
};

base::Vec3 AxisOf(const PaperPose& pose) noexcept;
PaperPose PoseOf(const base::Vec3& position_base_m, const base::Vec3& axis_base) noexcept;

struct PaperFit {
  PaperPose pose;
  double residual_rms_T = 0;  // of the weighted axes
  int evaluations = 0;        // of the cost, each with its gradient
  bool converged = false;
};

// One solver, problem built once: Solve only exchanges the readings.
class PaperSolver {
 public:
  explicit PaperSolver(PaperModel model);
  ~PaperSolver();
  PaperSolver(const PaperSolver&) = delete;
  PaperSolver& operator=(const PaperSolver&) = delete;

  // Warm: `start` is the pose of the scan before.
  PaperFit Solve(const PaperScan& scan, const PaperPose& start);

  // Cold: from nine fixed poses about the base, the best fit of all. The paper attains its start "by careful
  // construction of the hardware"; this is the generous reading of it.
  PaperFit SolveCold(const PaperScan& scan);

  // Sum of the squared weighted residuals in gauss^2 and its gradient at (x, y, z, theta, phi) in m and rad; for tests.
  double Cost(const PaperScan& scan, const PaperPose& pose, std::array<double, 5>& gradient) const;

 private:
  struct Problem;
  std::unique_ptr<Problem> problem_;
};

}  // namespace omni::peers
