#include <ceres/autodiff_cost_function.h>

#include <vector>

#include "service/base/eigen.h"
#include "service/peers/any_scalar_model.h"
#include "service/peers/ceres_pose.h"
#include "service/peers/whitening.h"

namespace omni::peers {
namespace {

struct AnySensor {
  Eigen::Vector3d position;
  Eigen::Vector3d over_r3;  // field shape of the charge at the core's centre
  Eigen::Matrix3d gain;
};

struct AnyModel {
  magnetics::DiscMagnet magnet;
  double core_radius_m = 0;
  double core_kappa = 0;
  std::vector<AnySensor> sensors;
};

AnyModel MakeAnyModel(const base::Calibration& calibration) {
  AnyModel model;
  model.magnet = magnetics::MakeDiscMagnet(calibration.magnet, calibration.moment_Am2);
  model.core_radius_m = calibration.core_radius_m;
  model.core_kappa = calibration.core_kappa;
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    const Eigen::Vector3d s = base::ToEigen(sensor.position_base_m);
    const double r = s.norm();
    model.sensors.push_back(
        {s, s / (r * r * r),
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
    V3<T> e1, e2;
    AnyTangents(u, e1, e2);
    const auto count = static_cast<std::size_t>(model.magnet.point_count);
    std::array<AnyImage<T>, magnetics::kMagnetPoints> images;
    for (std::size_t k = 0; k < count; ++k) {
      const magnetics::MagnetPoint& point = model.magnet.points[k];
      const V3<T> place = p + point.ring_1_m * e1 + point.ring_2_m * e2 + point.axial_m * u;
      images[k] = ImageOf<T>(point.share * model.magnet.moment_Am2 * u, place, model.core_radius_m, model.core_kappa);
    }
    for (std::size_t i = 0; i < model.sensors.size(); ++i) {
      const AnySensor& sensor = model.sensors[i];
      const V3<T> s = sensor.position.cast<T>();
      V3<T> B = AnyZonal<T>(model.magnet.zonal, u, s - p);
      for (std::size_t k = 0; k < count; ++k) {
        const V3<T> d = s - images[k].place;
        B += AnyDipole<T>(images[k].moment, d) + AnyCharge<T>(images[k].charge, d) -
             magnetics::kMu0Over4Pi * images[k].charge * sensor.over_r3.cast<T>();
      }
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
