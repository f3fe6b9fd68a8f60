// The peers' contact with the ball: a penalty on samples of their surface. Reduced to what a fair comparison needs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "service/haptics/deformable/build/lattice.h"

namespace omni::bench {

struct PeerTouch {
  std::array<std::uint32_t, 3> node;
  Eigen::Vector3d weights;
  Eigen::Vector3d out;  // of the ball, unit
  double inside_m;      // > 0
  double stiffness_N_m;
};

class PeerContact {
 public:
  // Penalty 300 E over the ball's radius and per area: its displacement is less than a hundredth of the body's.
  PeerContact(const haptics::TetLattice& lattice, double modulus_Pa, double ball_radius_m);

  // `position`: of the lattice's vertices, three numbers each.
  const std::vector<PeerTouch>& Find(const Eigen::VectorXd& position, const Eigen::Vector3d& centre);
  // Of the touches found last.
  Eigen::Vector3d ForceOnBall() const;

 private:
  struct Facet {
    std::array<std::uint32_t, 3> node;
    double area_m2;
    int cuts;  // along an edge
  };
  void Sample(const Facet& facet, const Eigen::Matrix3d& corners, const Eigen::Vector3d& centre);

  double radius_m_, penalty_N_m3_;
  std::vector<Facet> facets_;
  std::vector<PeerTouch> touches_;
};

}  // namespace omni::bench
