#include "service/sim/fields/charges.h"

#include <cmath>
#include <numbers>

#include "service/sim/fields/charge_kernel.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {
namespace {

constexpr double kFarAway_m = 1e3;

struct Node {
  double position = 0;
  double weight = 0;
};

// Gauss-Legendre nodes on [0, 1]: roots of P_n by Newton's method [Press et al., Numerical Recipes 3e, 4.6].
std::vector<Node> GaussNodes(int n) {
  std::vector<Node> nodes;
  for (int i = 0; i < n; ++i) {
    double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5));
    double slope = 1;
    for (int iteration = 0; iteration < 50; ++iteration) {
      double p = 1;
      double p_before = 0;
      for (int l = 0; l < n; ++l) {
        const double next = ((2 * l + 1) * x * p - l * p_before) / (l + 1);
        p_before = p;
        p = next;
      }
      slope = n * (x * p - p_before) / (x * x - 1);
      const double step = p / slope;
      x -= step;
      if (std::abs(step) < 1e-15) break;
    }
    nodes.push_back({0.5 * (1 + x), 1 / ((1 - x * x) * slope * slope)});
  }
  return nodes;
}

}  // namespace

void Charges::Resize(std::size_t count) {
  const std::size_t padded = (count + kChargeLanes - 1) / kChargeLanes * kChargeLanes;
  x.assign(padded, kFarAway_m);
  y.assign(padded, kFarAway_m);
  z.assign(padded, kFarAway_m);
  q.assign(padded, 0);
  count_ = count;
}

void FieldArray::Resize(const Charges& charges) {
  x.assign(charges.x.size(), 0);
  y.assign(charges.x.size(), 0);
  z.assign(charges.x.size(), 0);
}

Vec3 FieldOf(const Charges& charges, const Vec3& point_base_m) noexcept {
  static const ChargeSum sum = FastestChargeSum();
  const double point[3] = {point_base_m.x, point_base_m.y, point_base_m.z};
  double b[3];
  sum(charges.x.data(), charges.y.data(), charges.z.data(), charges.q.data(), charges.q.size(), point, b);
  return kMu0Over4Pi * Vec3{b[0], b[1], b[2]};
}

// Charge of a node: M dA with dA = 1/2 d(rho^2) dphi. Rings are turned against each other to spread the nodes.
MagnetFaces::MagnetFaces(const base::MagnetGeometry& magnet, int rings, int spokes)
    : half_height_m_(magnet.half_height_m) {
  const double magnetisation = magnet.remanence_T / kMu0;
  const double area = std::numbers::pi * magnet.radius_m * magnet.radius_m;
  int ring = 0;
  for (const Node& node : GaussNodes(rings)) {
    const double rho = magnet.radius_m * std::sqrt(node.position);
    for (int s = 0; s < spokes; ++s) {
      const double phi = 2 * std::numbers::pi * (s + 0.5 * (ring % 2)) / spokes;
      x_.push_back(rho * std::cos(phi));
      y_.push_back(rho * std::sin(phi));
      q_.push_back(magnetisation * area * node.weight / spokes);
    }
    ++ring;
  }
}

void MagnetFaces::PlaceCharges(const MagnetPose& pose, Charges& charges) const noexcept {
  const Vec3 e1 = Perpendicular(pose.axis_base);
  const Vec3 e2 = Cross(pose.axis_base, e1);
  const std::size_t count = x_.size();
  for (std::size_t i = 0; i < count; ++i) {
    const Vec3 in_plane = pose.centre_base_m + x_[i] * e1 + y_[i] * e2;
    for (const std::size_t face : {std::size_t{0}, std::size_t{1}}) {
      const double sign = face == 0 ? 1.0 : -1.0;
      const Vec3 p = in_plane + (sign * half_height_m_) * pose.axis_base;
      const std::size_t at = i + face * count;
      charges.x[at] = p.x;
      charges.y[at] = p.y;
      charges.z[at] = p.z;
      charges.q[at] = sign * q_[i];
    }
  }
}

}  // namespace omni::sim
