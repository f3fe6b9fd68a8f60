// A peer: co-rotational linear tetrahedra [Mueller & Gross 2004], one implicit quasi-static step per tick by conjugate
// gradients warm-started from the last one, contact by a penalty on samples of the surface. Reduced to what a fair
// comparison needs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "tests/bench/deformable/peer_contact.h"

namespace omni::bench {

class Corotational {
 public:
  // Clamped where z < `clamp_m`.
  Corotational(const haptics::TetLattice& lattice, double modulus_Pa, double nu, double clamp_m, double ball_radius_m);

  // One tick with a ball at `centre`; the force that lifts it.
  double Step(const Eigen::Vector3d& centre);
  std::size_t tets() const { return elements_.size(); }

 private:
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  struct Element {
    std::array<std::uint32_t, 4> node;
    std::array<Eigen::Vector3d, 4> gradient;
    Matrix12 rest;  // stiffness
    Eigen::Quaterniond rotation;
    std::array<std::uint32_t, 16> block;  // where its pairs of nodes are stored
  };

  void MakePattern();
  std::uint32_t BlockOf(std::uint32_t row, std::uint32_t column) const;
  void Assemble(Eigen::VectorXd& residual);
  void AddContact(const Eigen::Vector3d& centre, Eigen::VectorXd& residual);
  void Multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  void ConjugateGradients(const Eigen::VectorXd& residual, Eigen::VectorXd& step) const;

  PeerContact contact_;
  std::vector<Eigen::Vector3d> rest_;
  Eigen::VectorXd position_;
  std::vector<bool> held_;
  std::vector<Element> elements_;
  std::vector<std::uint32_t> row_, column_;  // the matrix of this tick, by blocks
  std::vector<Eigen::Matrix3d> block_;
};

}  // namespace omni::bench
