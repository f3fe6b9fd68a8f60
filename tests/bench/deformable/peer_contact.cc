#include "tests/bench/deformable/peer_contact.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace omni::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kPeerPenalty = 300;
constexpr double kSampleSize_balls = 0.12;  // samples lie about this far apart

}  // namespace

PeerContact::PeerContact(const haptics::TetLattice& lattice, double modulus_Pa, double ball_radius_m)
    : radius_m_(ball_radius_m), penalty_N_m3_(kPeerPenalty * modulus_Pa / ball_radius_m) {
  for (const auto& t : lattice.surface) {
    Matrix3d corner;
    for (int k = 0; k < 3; ++k) {
      const haptics::Vec3& v = lattice.vertices_base_m[t[static_cast<std::size_t>(k)]];
      corner.col(k) = Vector3d(v.x, v.y, v.z);
    }
    const Vector3d ab = corner.col(1) - corner.col(0), ac = corner.col(2) - corner.col(0);
    const double longest = std::max({ab.norm(), ac.norm(), (ac - ab).norm()});
    const int cuts = std::clamp(static_cast<int>(longest / (kSampleSize_balls * ball_radius_m)) + 1, 1, 24);
    facets_.push_back({t, 0.5 * ab.cross(ac).norm(), cuts});
  }
}

// The middles of cuts^2 equal triangles.
void PeerContact::Sample(const Facet& facet, const Matrix3d& corners, const Vector3d& centre) {
  const double n = facet.cuts;
  const double stiffness = penalty_N_m3_ * facet.area_m2 / (n * n);
  for (int i = 0; i < facet.cuts; ++i) {
    for (int j = 0; i + j < facet.cuts; ++j) {
      for (const double third : {1.0 / 3, 2.0 / 3}) {
        if (third > 0.5 && i + j >= facet.cuts - 1) continue;
        Vector3d w((i + third) / n, (j + third) / n, 0);
        w[2] = 1 - w[0] - w[1];
        const Vector3d away = corners * w - centre;
        const double inside = radius_m_ - away.norm();
        if (inside > 0) touches_.push_back({facet.node, w, away.normalized(), inside, stiffness});
      }
    }
  }
}

const std::vector<PeerTouch>& PeerContact::Find(const Eigen::VectorXd& position, const Vector3d& centre) {
  touches_.clear();
  for (const Facet& facet : facets_) {
    Matrix3d corners;
    for (int k = 0; k < 3; ++k) {
      corners.col(k) = position.segment<3>(3 * static_cast<Eigen::Index>(facet.node[static_cast<std::size_t>(k)]));
    }
    const Vector3d middle = corners.rowwise().mean();
    const double reach = (corners.colwise() - middle).colwise().norm().maxCoeff();
    if ((middle - centre).norm() < radius_m_ + reach) Sample(facet, corners, centre);
  }
  return touches_;
}

Vector3d PeerContact::ForceOnBall() const {
  Vector3d force = Vector3d::Zero();
  for (const PeerTouch& t : touches_) force -= t.stiffness_N_m * t.inside_m * t.out;
  return force;
}

}  // namespace omni::bench
