#include "service/magnetics/coil.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "service/base/limits.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/loop_field.h"
#include "service/magnetics/zonal.h"

namespace omni::magnetics {
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

}  // namespace omni::magnetics
