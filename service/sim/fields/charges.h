// The tool's magnet as magnetic charges on its two faces, and the charges it induces in the iron core.
//
// A disc magnetised along its axis is two discs of surface charge +-M, M = Br / mu0 [Jackson 3e, 5.99]. Each disc is
// summed by Gauss quadrature in rho^2 times equal steps in angle, which is exact for smooth fields up to a high order.
// The core's answer is in core_images.h. docs/theory/truth.md (1), (2).
#pragma once

#include <cstddef>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {

struct MagnetPose {
  Vec3 centre_base_m;
  Vec3 axis_base{0, 0, -1};
};

// Magnetic charges, A m, as structure of arrays, padded to whole vectors by charges of zero far away.
struct Charges {
  std::vector<double> x, y, z, q;
  std::size_t size() const noexcept { return count_; }
  Vec3 position(std::size_t i) const noexcept { return {x[i], y[i], z[i]}; }
  void Resize(std::size_t count);

 private:
  std::size_t count_ = 0;
};

// A vector where each charge lies, with the charges' padding.
struct FieldArray {
  std::vector<double> x, y, z;
  Vec3 operator[](std::size_t i) const noexcept { return {x[i], y[i], z[i]}; }
  void Resize(const Charges& charges);
};

// B(p) = mu0 / 4 pi sum q d / |d|^3, d = p - charge.
Vec3 FieldOf(const Charges& charges, const Vec3& point_base_m) noexcept;

// Nodes of one face in the magnet's own frame.
class MagnetFaces {
 public:
  // rings x spokes nodes on each face.
  MagnetFaces(const base::MagnetGeometry& magnet, int rings, int spokes);

  std::size_t charge_count() const noexcept { return 2 * x_.size(); }
  // `charges` has charge_count() entries.
  void PlaceCharges(const MagnetPose& pose, Charges& charges) const noexcept;

 private:
  std::vector<double> x_, y_, q_;
  double half_height_m_;
};

struct ForceAndTorque {
  Vec3 force_N;
  Vec3 torque_Nm;  // about the magnet's centre
};

}  // namespace omni::sim
