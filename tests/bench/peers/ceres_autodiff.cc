#include <ceres/autodiff_cost_function.h>

#include <vector>

#include "service/base/eigen.h"
#include "tests/bench/peers/any_scalar_model.h"
#include "tests/bench/peers/ceres_pose.h"
#include "tests/bench/peers/whitening.h"

namespace omni::peers {
namespace {

struct AnySensor {
  Eigen::Vector3d position;
  Eigen::Vector3d image;           // (a/r)^2 s
  Eigen::Matrix3d reflection;      // kappa (a/r)^3 (2 n n^T - 1)
  Eigen::Vector3d over_potential;  // -kappa a/r^2 n
  Eigen::Matrix3d gain;
};

struct AnyModel {
  magnetics::DiscMagnet magnet;
  std::vector<AnySensor> sensors;
};

AnyModel MakeAnyModel(const base::Calibration& calibration) {
  AnyModel model;
  model.magnet = magnetics::MakeDiscMagnet(calibration.magnet, calibration.moment_Am2);
  const double a = calibration.core_radius_m;
  const double kappa = calibration.core_kappa;
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    const Eigen::Vector3d s = base::ToEigen(sensor.position_base_m);
    const double r = s.norm();
    const Eigen::Vector3d n = s / r;
    const Eigen::Matrix3d mirror = 2 * n * n.transpose() - Eigen::Matrix3d::Identity();
    model.sensors.push_back(
        {s, a * a / (r * r) * s, kappa * std::pow(a / r, 3) * mirror, -kappa * a / (r * r) * n,
         Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(sensor.gain_sensor_base.data())});
  }
  return model;
}

struct AutodiffResidual {
  const AnyModel& model;
  const PeerScan& scan;

  template <class T>
  bool operator()(const T* position, const T* axis, T* residuals) const {
    const V3<T> p(position[0], position[1], position[2]);
    const V3<T> u = V3<T>(axis[0], axis[1], axis[2]).normalized();
    const T centre = AnyZonalPotential<T>(model.magnet.zonal, u, -p);
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
      const AnySensor& sensor = model.sensors[i];
      const V3<T> d = sensor.image.cast<T>() - p;
      const T potential = AnyZonalPotential<T>(model.magnet.zonal, u, d) - centre;
      const V3<T> B = AnyZonal<T>(model.magnet.zonal, u, V3<T>(sensor.position.cast<T>() - p)) +
                      sensor.reflection.cast<T>() * AnyZonal<T>(model.magnet.zonal, u, d) +
                      potential * sensor.over_potential.cast<T>();
      const V3<T> reading = sensor.gain.cast<T>() * B;
      for (std::size_t axis_index = 0; axis_index < 3; ++axis_index) {
        const std::size_t row = 3 * i + axis_index;
        residuals[row] = scan.inverse_sigma[row] * reading[static_cast<int>(axis_index)] - scan.whitened[row];
      }
    }
    RemoveNuisance(scan, residuals, 1);
    return true;
  }
};

class CeresAutodiff final : public Peer {
 public:
  CeresAutodiff(const base::Calibration& calibration, PeerLinearSolver linear, const PeerOptions& options)
      : model_(MakeAnyModel(calibration)), pose_(MakeCost(), linear, options) {}

  PeerFit Solve(const PeerScan& scan, const PeerPose& start) override {
    scan_ = scan;
    return pose_.Solve(start);
  }

 private:
  std::unique_ptr<ceres::CostFunction> MakeCost() {
    return std::make_unique<ceres::AutoDiffCostFunction<AutodiffResidual, kPeerReadings, 3, 3>>(
        new AutodiffResidual{model_, scan_});
  }

  AnyModel model_;
  PeerScan scan_;
  CeresPose pose_;
};

}  // namespace

std::unique_ptr<Peer> MakeCeresAutodiff(const base::Calibration& calibration, PeerLinearSolver linear,
                                        const PeerOptions& options) {
  return std::make_unique<CeresAutodiff>(calibration, linear, options);
}

}  // namespace omni::peers
