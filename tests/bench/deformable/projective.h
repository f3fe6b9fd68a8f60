// A peer: projective dynamics [Bouaziz, Martin, Liu, Kavan & Pauly 2014] without inertia. A tick has ten iterations:
// every tetrahedron finds its nearest rotation and its nearest shape of equal volume, then one prefactored solve moves
// all nodes. Reduced to what a fair comparison needs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>

#include "tests/bench/deformable/peer_contact.h"

namespace omni::bench {

class Projective {
 public:
  // Clamped where z < `clamp_m`. Weights 2 mu to the rotation and 3 lambda to the volume: linear elasticity while
  // strains are small.
  Projective(const haptics::TetLattice& lattice, double modulus_Pa, double nu, double clamp_m, double ball_radius_m);

  // One tick with a ball at `centre`; the force that lifts it.
  double Step(const Eigen::Vector3d& centre);
  std::size_t tets() const { return elements_.size(); }
  static constexpr int kIterations = 10;  // a tick

 private:
  using Sparse = Eigen::SparseMatrix<double>;
  struct ProjectiveTet {
    std::array<std::uint32_t, 4> node;
    std::array<Eigen::Vector3d, 4> gradient;
    double volume_m3;
    Eigen::Quaterniond rotation;
  };
  struct Anchor {  // of the matrix: a held node times this entry goes to the right
    Eigen::Index row, held;
    double entry;
  };

  void AssembleRest();
  void Refactor();
  Eigen::Matrix<double, Eigen::Dynamic, 3> Project();
  void Iterate(const Eigen::Vector3d& centre);

  double mu_Pa_, lambda_Pa_;
  double ball_radius_m_;
  PeerContact contact_;
  std::vector<PeerTouch> touches_;    // those in the factor
  std::vector<Eigen::Index> column_;  // of every node; -1: held
  Eigen::Index free_ = 0;
  Eigen::VectorXd position_;
  std::vector<ProjectiveTet> elements_;
  std::vector<Anchor> anchors_;
  Sparse rest_;
  Eigen::SimplicialLLT<Sparse> solver_;
};

}  // namespace omni::bench
