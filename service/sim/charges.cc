#include "service/sim/charges.h"

#include <cmath>
#include <numbers>

namespace omni::sim {
namespace {

constexpr double kMu0 = 4e-7 * std::numbers::pi;
constexpr double kMu0Over4Pi = 1e-7;

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
  x.resize(count);
  y.resize(count);
  z.resize(count);
  q.resize(count);
}

Vec3 FieldOf(const Charges& charges, const Vec3& point_base_m) noexcept {
  Vec3 b;
  for (std::size_t i = 0; i < charges.size(); ++i) {
    const double dx = point_base_m.x - charges.x[i];
    const double dy = point_base_m.y - charges.y[i];
    const double dz = point_base_m.z - charges.z[i];
    const double d2 = dx * dx + dy * dy + dz * dz;
    const double k = charges.q[i] / (d2 * std::sqrt(d2));
    b.x += k * dx;
    b.y += k * dy;
    b.z += k * dz;
  }
  return kMu0Over4Pi * b;
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

void MagnetFaces::Place(const MagnetPose& pose, Charges& charges) const noexcept {
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

void PlaceImages(const Charges& charges, double core_radius_m, double core_kappa, Charges& images) noexcept {
  const std::size_t count = charges.size();
  double centre = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double r2 = charges.x[i] * charges.x[i] + charges.y[i] * charges.y[i] + charges.z[i] * charges.z[i];
    const double scale = core_radius_m * core_radius_m / r2;
    const double q = core_kappa * charges.q[i] * core_radius_m / std::sqrt(r2);
    images.x[i] = scale * charges.x[i];
    images.y[i] = scale * charges.y[i];
    images.z[i] = scale * charges.z[i];
    images.q[i] = -q;
    centre += q;
  }
  images.x[count] = images.y[count] = images.z[count] = 0;
  images.q[count] = centre;
}

}  // namespace omni::sim
