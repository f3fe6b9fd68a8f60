// A peer: co-rotational linear tetrahedra [Mueller & Gross 2004], one implicit quasi-static step a tick by conjugate
// gradients warm-started from the last one, contact by a penalty on samples of the surface. Only what a fair comparison
// needs.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "service/haptics/deformable/lattice.h"

namespace omni::bench {

class Corotational {
 public:
  // Clamped where z < `clamp_m`.
  Corotational(const haptics::TetLattice& lattice, double modulus_Pa, double nu, double clamp_m);

  // One tick with a ball at `centre`; returns the force that lifts it.
  double Step(const Eigen::Vector3d& centre, double radius_m);
  std::size_t tets() const { return elements_.size(); }

 private:
  using Matrix12 = Eigen::Matrix<double, 12, 12>;
  struct Element {
    std::array<std::uint32_t, 4> node;
    std::array<Eigen::Vector3d, 4> gradient;
    Matrix12 rest;    // stiffness
    Matrix12 turned;  // R k R^T of this tick
    Eigen::Quaterniond rotation;
  };
  struct Touch {
    std::array<std::uint32_t, 3> node;
    Eigen::Vector3d weights, normal;
    double stiffness;
  };

  void Rotate(Eigen::VectorXd& residual);
  double AddContact(const Eigen::Vector3d& centre, double radius_m, Eigen::VectorXd& residual);
  void Multiply(const Eigen::VectorXd& x, Eigen::VectorXd& y) const;
  void ConjugateGradients(const Eigen::VectorXd& residual, Eigen::VectorXd& step) const;

  double penalty_;  // N/m^3
  std::vector<Eigen::Vector3d> rest_;
  Eigen::VectorXd position_;
  std::vector<bool> held_;
  std::vector<Element> elements_;
  std::vector<std::array<std::uint32_t, 3>> surface_;
  std::vector<Touch> touches_;
};

}  // namespace omni::bench
