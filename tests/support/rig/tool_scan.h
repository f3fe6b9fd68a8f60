// Random poses of the tool and scans that the tracker's own model predicts for them.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/base/eigen.h"
#include "service/base/hall_scan.h"
#include "service/tracker/kernel/linearise.h"
#include "service/tracker/solve/gap.h"
#include "service/tracker/solve/solver.h"
#include "tests/support/numeric.h"

namespace omni::support {

// Centre at |p| in [r_min, r_max] over the upper hemisphere, axis within `tilt_max_rad` of the inward or outward radius
// (or anywhere: pi), the disc clear of the hull.
inline tracker::Pose RandomPose(Rng& rng, const tracker::Model& model, double r_min_m, double r_max_m,
                                double tilt_max_rad = std::numbers::pi) {
  for (;;) {
    Eigen::Vector3d n = RandomUnit(rng);
    n.z() = std::abs(n.z());
    const Eigen::Vector3d p = Uniform(rng, r_min_m, r_max_m) * n;
    const Eigen::Vector3d u = RandomUnit(rng);
    if (std::acos(std::clamp(std::abs(u.dot(n)), 0.0, 1.0)) > tilt_max_rad) continue;
    const double gap_m = tracker::CylinderGap(base::FromEigen(p), base::FromEigen(u), model.magnet_radius_m,
                                              model.magnet_half_height_m, model.hull_radius_m);
    if (gap_m >= 0) return {p, u};
  }
}

struct ScanOptions {
  double noise_scale = 0;  // times the model's rms
  std::array<double, base::kCoilCount> coil_current_A{};
};

inline base::HallScan MakeScan(const tracker::Model& model, const tracker::Pose& pose, std::int64_t t_ns, Rng& rng,
                               const ScanOptions& options = {}) {
  tracker::ModelField field;
  tracker::EvaluateField(model, tracker::MakePosePoint(pose), field);
  std::normal_distribution<double> normal;
  base::HallScan scan;
  scan.t_ns = t_ns;
  scan.fresh_mask = 0xff;
  scan.coil_current_A = options.coil_current_A;
  scan.coil_temperature_C = {25, 25, 25};
  for (std::size_t i = 0; i < tracker::kSensors; ++i) {
    std::array<double, 3> B{};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      B[axis] = field.field_sensor_T[3 * i + axis] + options.noise_scale * model.noise_T[axis] * normal(rng);
      for (std::size_t k = 0; k < base::kCoilCount; ++k) {
        B[axis] += model.coil_map_T_A[(3 * i + axis) * base::kCoilCount + k] * options.coil_current_A[k];
      }
    }
    scan.field_sensor_T[i] = {B[0], B[1], B[2]};
  }
  return scan;
}

// Adds a field, frame B, to what one sensor reads.
inline void AddField(const tracker::Model& model, std::size_t sensor, const Eigen::Vector3d& field_base_T,
                     base::HallScan& scan) {
  Eigen::Vector3d read_T = base::ToEigen(scan.field_sensor_T[sensor]);
  for (std::size_t e = 0; e < 9; ++e) {
    read_T[static_cast<Eigen::Index>(e / 3)] +=
        model.gain_sensor_base[e][sensor] * field_base_T[static_cast<Eigen::Index>(e % 3)];
  }
  scan.field_sensor_T[sensor] = base::FromEigen(read_T);
}

}  // namespace omni::support
