#include "service/magnetics/array.h"

#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::magnetics {

using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

double MomentOf(const base::MagnetGeometry& magnet) noexcept { return MakeDiscMagnet(magnet).moment_Am2; }

void AddWindings(const std::vector<base::CoilGeometry>& coils, base::Calibration& array) {
  for (std::size_t k = 0; k < coils.size(); ++k) {
    const auto winding = MakeWinding(coils[k], static_cast<int>(k));
    const CoilMoments core = CoreMoments(winding, array.core_radius_m, array.core_kappa);
    const Eigen::Vector3d axis = base::ToEigen(coils[k].axis_base).normalized();
    for (base::SensorCalibration& sensor : array.sensors) {
      const Eigen::Map<const RowMajor3d> gain(sensor.gain_sensor_base.data());
      Eigen::Map<RowMajor3d> map(sensor.current_map_T_A.data());
      map.col(static_cast<int>(k)) = gain * CoilField(winding, core, axis, base::ToEigen(sensor.position_base_m));
    }
  }
}

}  // namespace omni::magnetics
