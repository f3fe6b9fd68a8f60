// Bases in spaces, and measurements of them, for the tests of service/alignment.
#pragma once

#include <random>
#include <vector>

#include <Eigen/Geometry>

#include "service/alignment/rigid.h"
#include "service/base/eigen.h"

namespace omni::test {

class AlignmentScenario {
 public:
  explicit AlignmentScenario(unsigned seed) : random_(seed) {}

  double Uniform(double low, double high) { return std::uniform_real_distribution<double>(low, high)(random_); }
  Eigen::Vector3d Normal(double sigma) {
    std::normal_distribution<double> normal(0, 1);
    const double x = normal(random_), y = normal(random_), z = normal(random_);
    return sigma * Eigen::Vector3d(x, y, z);
  }
  Eigen::Quaterniond Turn(double most_rad) {
    const Eigen::Vector3d axis = Normal(1).normalized();
    return Eigen::Quaterniond(Eigen::AngleAxisd(Uniform(-most_rad, most_rad), axis));
  }

  // Level: B's z is L's y.
  alignment::Rigid LevelBase() {
    const Eigen::Quaterniond yaw(Eigen::AngleAxisd(Uniform(-3.1, 3.1), Eigen::Vector3d::UnitY()));
    return {.orientation = base::FromEigen(
                Eigen::Quaterniond(yaw * base::ToEigen(alignment::LevelBase().orientation)).normalized()),
            .position_m = base::FromEigen(Eigen::Vector3d(Uniform(-3, 3), Uniform(-1, 2), Uniform(-3, 3)))};
  }
  alignment::Rigid AnyBase() {
    alignment::Rigid base = LevelBase();
    base.orientation = base::FromEigen((Turn(3.1) * base::ToEigen(base.orientation)).normalized());
    return base;
  }
  base::Vec3 PointOfBase() {
    return base::FromEigen(Eigen::Vector3d(Uniform(-0.08, 0.08), Uniform(-0.08, 0.08), Uniform(-0.07, 0.1)));
  }

  // The controller has some pose with its tip at that point of the base, up to `noise_m`.
  alignment::Sample At(const alignment::Rigid& X_LB, const base::Vec3& p_B, const base::Vec3& tip, double noise_m,
                       int group) {
    const Eigen::Quaterniond q_LC = Turn(0.7);
    const Eigen::Vector3d p_L = base::ToEigen(alignment::TransformPoint(X_LB, p_B)) + Normal(noise_m);
    return {.t_s = time_s_ += 0.03,
            .controller_space = {.orientation = base::FromEigen(q_LC),
                                 .position_m = base::FromEigen(Eigen::Vector3d(p_L - q_LC * base::ToEigen(tip)))},
            .point_base_m = p_B,
            .group = group};
  }

 private:
  std::mt19937 random_;
  double time_s_ = 0;
};

}  // namespace omni::test
