#include "service/magnetics/coil.h"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/base/eigen.h"
#include "service/base/limits.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/zonal.h"

namespace omni::magnetics {

// a0 = 1, g0 = sqrt(1 - m), c0^2 = m: K = pi / (2 a_n), E = K (1 - sum 2^(n-1) c_n^2)   [Abramowitz & Stegun 17.6]
EllipticIntegrals CompleteElliptic(double m) noexcept {
  double a = 1;
  double g = std::sqrt(1 - m);
  double weight = 0.5;
  double sum = weight * m;
  for (int n = 0; n < 12; ++n) {
    const double c = 0.5 * (a - g);
    const double next = 0.5 * (a + g);
    g = std::sqrt(a * g);
    a = next;
    weight *= 2;
    sum += weight * c * c;
    if (!(std::abs(c) > 1e-16 * a)) break;
  }
  const double K = 0.5 * std::numbers::pi / a;
  return {K, K * (1 - sum)};
}

// k^2 = 4 a rho / s, s = (a + rho)^2 + z^2, t = (a - rho)^2 + z^2:
//   Bz   = mu0/2pi 1/sqrt(s) [K + (a^2 - rho^2 - z^2)/t E]
//   Brho = mu0/2pi z/(rho sqrt(s)) [-K + (a^2 + rho^2 + z^2)/t E]   [Smythe, Static and Dynamic Electricity, 7.10]
// Near the axis the bracket of Brho cancels; there Brho = -rho/2 dBz/dz with Bz = mu0 a^2 / (2 (a^2 + z^2)^(3/2)).
LoopField FieldOfLoop(double radius_m, double rho_m, double z_m) noexcept {
  const double a = radius_m;
  const double s = (a + rho_m) * (a + rho_m) + z_m * z_m;
  const double t = (a - rho_m) * (a - rho_m) + z_m * z_m;
  const EllipticIntegrals e = CompleteElliptic(4 * a * rho_m / s);
  const double scale = kMu0 / (2 * std::numbers::pi * std::sqrt(s));
  const double a2 = a * a;
  const double rest = rho_m * rho_m + z_m * z_m;
  const double Bz = scale * (e.K + (a2 - rest) / t * e.E);
  if (rho_m < 1e-4 * std::sqrt(a2 + z_m * z_m)) {
    const double h2 = a2 + z_m * z_m;
    return {0.75 * kMu0 * a2 * rho_m * z_m / (h2 * h2 * std::sqrt(h2)), Bz};
  }
  return {scale * z_m / rho_m * ((a2 + rest) / t * e.E - e.K), Bz};
}

Eigen::Vector3d FieldOfLoop(double radius_m, double height_m, const Eigen::Vector3d& axis,
                            const Eigen::Vector3d& x) noexcept {
  const double z = axis.dot(x);
  const Eigen::Vector3d radial = x - z * axis;
  const double rho = radial.norm();
  const LoopField B = FieldOfLoop(radius_m, rho, z - height_m);
  if (!(rho > 0)) return B.z_T_A * axis;
  return B.z_T_A * axis + (B.rho_T_A / rho) * radial;
}

namespace {

// P'_l(c) for l = 1, 3, 5, ...: the Gegenbauer polynomial C^(3/2)_(l-1)(c).
CoilMoments LegendreDerivatives(double c) {
  CoilMoments result{};
  double P_below = 1, P1_below = 0, P = c, P1 = 1;
  double l = 1;
  for (double& derivative : result) {
    derivative = P1;
    for (int twice = 0; twice < 2; ++twice, l += 1) {
      const double P_above = ((2 * l + 1) * c * P - l * P_below) / (l + 1);
      const double P1_above = P1_below + (2 * l + 1) * P;
      P_below = P, P1_below = P1, P = P_above, P1 = P1_above;
    }
  }
  return result;
}

}  // namespace

std::vector<Turn> MakeWinding(const base::CoilGeometry& coil, int index) {
  std::vector<Turn> winding;
  const int shells = base::kCoilCount * coil.layers;
  const double pitch = (coil.shell_radius_max_m - coil.shell_radius_min_m) / shells;
  const int fewest = coil.turns / coil.layers;
  const int fuller_layers = coil.turns % coil.layers;
  for (int layer = 0; layer < coil.layers; ++layer) {
    const double R = coil.shell_radius_min_m + (base::kCoilCount * layer + index + 0.5) * pitch;
    const int turns = layer >= coil.layers - fuller_layers ? fewest + 1 : fewest;
    for (int n = 0; n < turns; ++n) {
      const double z = coil.band_half_width_m * ((2 * n + 1.0) / turns - 1);
      winding.push_back({std::sqrt(std::max(0.0, R * R - z * z)), z});
    }
  }
  return winding;
}

// A loop of radius rho at height z, R^2 = rho^2 + z^2: q_l = 2 pi rho^2 R^(l-1) P'_l(z/R) / (l+1)
// [Jackson 3e, 5.5, exterior expansion of a loop; l = 1: the area].
CoilMoments WindingMoments(const std::vector<Turn>& winding) {
  CoilMoments moments{};
  for (const Turn& turn : winding) {
    const double R2 = turn.radius_m * turn.radius_m + turn.height_m * turn.height_m;
    const CoilMoments P1 = LegendreDerivatives(turn.height_m / std::sqrt(R2));
    double scale = 2 * std::numbers::pi * turn.radius_m * turn.radius_m;
    for (std::size_t j = 0; j < moments.size(); ++j, scale *= R2) {
      moments[j] += scale * P1[j] / (2.0 * static_cast<double>(j) + 2);
    }
  }
  return moments;
}

// On the axis inside, Bz = sum b_l z^(l-1) with b_l = mu0 rho^2 / (2 R^(l+2)) P'_l(z/R). The core answers order l with
// q_l = kappa_l 4 pi b_l a^(2l+1) / (mu0 l), kappa_l = l (mu-1)/(l mu + l + 1) = 3 l kappa / (2 l + 1 + kappa (l - 1))
// [Jackson 3e, 5.11, order by order].
CoilMoments CoreMoments(const std::vector<Turn>& winding, double core_radius_m, double kappa) {
  CoilMoments moments{};
  const double a2 = core_radius_m * core_radius_m;
  for (const Turn& turn : winding) {
    const double R2 = turn.radius_m * turn.radius_m + turn.height_m * turn.height_m;
    const double R = std::sqrt(R2);
    const CoilMoments P1 = LegendreDerivatives(turn.height_m / R);
    // (4 pi / mu0) (mu0 / 2) rho^2 a^(2l+1) / R^(l+2) at l = 1; two orders up: times a^4 / R^2.
    double scale = 2 * std::numbers::pi * turn.radius_m * turn.radius_m * a2 * core_radius_m / (R2 * R);
    for (std::size_t j = 0; j < moments.size(); ++j, scale *= a2 * a2 / R2) {
      const double l = 2.0 * static_cast<double>(j) + 1;
      moments[j] += scale * P1[j] / l * (3 * l * kappa / (2 * l + 1 + kappa * (l - 1)));
    }
  }
  return moments;
}

Eigen::Vector3d CoilField(const std::vector<Turn>& winding, const CoilMoments& core, const Eigen::Vector3d& axis,
                          const Eigen::Vector3d& x) {
  Eigen::Vector3d B = ZonalField(core, axis, x);
  for (const Turn& turn : winding) B += FieldOfLoop(turn.radius_m, turn.height_m, axis, x);
  return B;
}

namespace {

using Eigen::Matrix3d;
using RowMajor3d = Eigen::Matrix<double, 3, 3, Eigen::RowMajor>;

constexpr double kMomentMin_Am2 = 1e-3;  // per ampere, of the weakest direction: less is no coil

// (sum D^T D) P = sum D^T A, D = G DipoleMatrix(s)
Matrix3d CoilMomentsFromMaps(const base::Calibration& calibration) {
  Matrix3d square = Matrix3d::Zero(), along = Matrix3d::Zero();
  for (const base::SensorCalibration& sensor : calibration.sensors) {
    const Matrix3d unit = Eigen::Map<const RowMajor3d>(sensor.gain_sensor_base.data()) *
                          DipoleMatrix(base::ToEigen(sensor.position_base_m));
    square += unit.transpose() * unit;
    along += unit.transpose() * Eigen::Map<const RowMajor3d>(sensor.current_map_T_A.data());
  }
  return square.ldlt().solve(along);
}

}  // namespace

Matrix3d CoreCurrents(const base::Calibration& calibration) {
  const double core_Am2_T = std::pow(calibration.core_radius_m, 3) * calibration.core_kappa / kMu0Over4Pi;
  if (!(core_Am2_T > 0)) return Matrix3d::Zero();
  const Matrix3d moments = CoilMomentsFromMaps(calibration);
  const bool three = moments.allFinite() && std::abs(moments.determinant()) > std::pow(kMomentMin_Am2, 3);
  return three ? Matrix3d(core_Am2_T * moments.inverse()) : Matrix3d(Matrix3d::Zero());
}

}  // namespace omni::magnetics
