// References for the magnet that share no formula with the models under test: charged faces by quadrature.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <numbers>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"

namespace omni::support {

struct PointCharge {
  double q = 0;            // A m
  Eigen::Vector3d offset;  // along (e1, e2, u)
};

// The two faces of an axially magnetised disc: charge density +- Br/mu0 on equal-area cells.
inline std::vector<PointCharge> DiscCharges(const base::MagnetGeometry& magnet, int rings, int sectors) {
  std::vector<PointCharge> charges;
  const double pi = std::numbers::pi;
  const double face_Am = magnet.remanence_T / magnetics::kMu0 * pi * magnet.radius_m * magnet.radius_m;
  for (int ring = 0; ring < rings; ++ring) {
    const double r = magnet.radius_m * std::sqrt((ring + 0.5) / rings);
    for (int sector = 0; sector < sectors; ++sector) {
      const double phi = 2 * pi * (sector + 0.5 * (ring % 2)) / sectors;
      for (const double side : {-1.0, 1.0}) {
        charges.push_back(
            {side * face_Am / (rings * sectors), {r * std::cos(phi), r * std::sin(phi), side * magnet.half_height_m}});
      }
    }
  }
  return charges;
}

inline Eigen::Vector3d ChargePosition(const PointCharge& charge, const Eigen::Vector3d& p, const Eigen::Vector3d& u) {
  const magnetics::TangentBasis e = magnetics::MakeTangentBasis(u);
  return p + charge.offset.x() * e.e1 + charge.offset.y() * e.e2 + charge.offset.z() * u;
}

}  // namespace omni::support
