#include "tests/bench/deformable/corotational.h"

#include <Eigen/LU>
#include <algorithm>

#include "tests/bench/deformable/peer_rotation.h"

namespace omni::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kTolerance = 1e-3;
constexpr int kMostIterations = 200;

}  // namespace

Corotational::Corotational(const haptics::TetLattice& lattice, double modulus_Pa, double nu, double clamp_m,
                           double ball_radius_m)
    : contact_(lattice, modulus_Pa, ball_radius_m) {
  const double mu = modulus_Pa / (2 * (1 + nu));
  const double lambda = modulus_Pa * nu / ((1 + nu) * (1 - 2 * nu));
  for (const haptics::Vec3& v : lattice.vertices_base_m) {
    rest_.emplace_back(v.x, v.y, v.z);
    held_.push_back(v.z < clamp_m);
  }
  position_.resize(3 * static_cast<Eigen::Index>(rest_.size()));
  for (std::size_t n = 0; n < rest_.size(); ++n) position_.segment<3>(3 * static_cast<Eigen::Index>(n)) = rest_[n];
  for (const auto& tet : lattice.tets) {
    Element e{tet, {}, Matrix12::Zero(), Eigen::Quaterniond::Identity(), {}};
    Matrix3d edges;
    for (int c = 0; c < 3; ++c) edges.col(c) = rest_[tet[static_cast<std::size_t>(c + 1)]] - rest_[tet[0]];
    const double volume = edges.determinant() / 6;
    const Matrix3d inverse = edges.inverse();
    e.gradient[0] = Vector3d::Zero();
    for (int c = 0; c < 3; ++c) {
      e.gradient[static_cast<std::size_t>(c + 1)] = inverse.row(c).transpose();
      e.gradient[0] -= e.gradient[static_cast<std::size_t>(c + 1)];
    }
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) {
        const Vector3d& ga = e.gradient[a];
        const Vector3d& gb = e.gradient[b];
        e.rest.block<3, 3>(3 * static_cast<int>(a), 3 * static_cast<int>(b)) =
            volume * (lambda * ga * gb.transpose() + mu * gb * ga.transpose() + mu * ga.dot(gb) * Matrix3d::Identity());
      }
    }
    elements_.push_back(e);
  }
  MakePattern();
}

// One 3 x 3 block for every pair of nodes that share a tetrahedron, rows sorted; the pattern is made once.
void Corotational::MakePattern() {
  std::vector<std::vector<std::uint32_t>> around(rest_.size());
  for (const Element& e : elements_) {
    for (const std::uint32_t a : e.node) around[a].insert(around[a].end(), e.node.begin(), e.node.end());
  }
  row_.push_back(0);
  for (auto& list : around) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
    column_.insert(column_.end(), list.begin(), list.end());
    row_.push_back(static_cast<std::uint32_t>(column_.size()));
  }
  block_.resize(column_.size());
  for (Element& e : elements_) {
    for (std::size_t a = 0; a < 4; ++a) {
      for (std::size_t b = 0; b < 4; ++b) e.block[4 * a + b] = BlockOf(e.node[a], e.node[b]);
    }
  }
}

std::uint32_t Corotational::BlockOf(std::uint32_t row, std::uint32_t column) const {
  const auto first = column_.begin() + row_[row];
  return static_cast<std::uint32_t>(std::lower_bound(first, column_.begin() + row_[row + 1], column) - column_.begin());
}

// f = R k (R^T x - x0), K = R k R^T.
void Corotational::Assemble(VectorXd& residual) {
  for (Matrix3d& block : block_) block.setZero();
  for (Element& e : elements_) {
    Matrix3d f = Matrix3d::Zero();
    for (std::size_t a = 0; a < 4; ++a) f += position_.segment<3>(3 * e.node[a]) * e.gradient[a].transpose();
    ExtractRotation(f, e.rotation);
    const Matrix3d r = e.rotation.toRotationMatrix();
    Eigen::Matrix<double, 12, 1> u;
    for (std::size_t a = 0; a < 4; ++a) {
      u.segment<3>(3 * static_cast<int>(a)) = r.transpose() * position_.segment<3>(3 * e.node[a]) - rest_[e.node[a]];
    }
    const Eigen::Matrix<double, 12, 1> force = e.rest * u;
    for (std::size_t a = 0; a < 4; ++a) {
      const int i = 3 * static_cast<int>(a);
      residual.segment<3>(3 * e.node[a]) -= r * force.segment<3>(i);
      for (std::size_t b = 0; b < 4; ++b) {
        block_[e.block[4 * a + b]] += r * e.rest.block<3, 3>(i, 3 * static_cast<int>(b)) * r.transpose();
      }
    }
  }
}

void Corotational::AddContact(const Vector3d& centre, VectorXd& residual) {
  for (const PeerTouch& t : contact_.Find(position_, centre)) {
    const Matrix3d stiffness = t.stiffness_N_m * t.out * t.out.transpose();
    for (std::size_t a = 0; a < 3; ++a) {
      const double weight = t.weights[static_cast<Eigen::Index>(a)];
      residual.segment<3>(3 * t.node[a]) += t.stiffness_N_m * t.inside_m * weight * t.out;
      for (std::size_t b = 0; b < 3; ++b) {
        block_[BlockOf(t.node[a], t.node[b])] += weight * t.weights[static_cast<Eigen::Index>(b)] * stiffness;
      }
    }
  }
}

void Corotational::Multiply(const VectorXd& x, VectorXd& y) const {
  y.resize(x.size());
  for (std::uint32_t n = 0; n < rest_.size(); ++n) {
    Vector3d sum = Vector3d::Zero();
    if (!held_[n]) {
      for (std::uint32_t k = row_[n]; k < row_[n + 1]; ++k) sum += block_[k] * x.segment<3>(3 * column_[k]);
    }
    y.segment<3>(3 * n) = sum;
  }
}

void Corotational::ConjugateGradients(const VectorXd& residual, VectorXd& step) const {
  VectorXd diagonal(residual.size());
  for (std::uint32_t n = 0; n < rest_.size(); ++n) diagonal.segment<3>(3 * n) = block_[BlockOf(n, n)].diagonal();
  step.setZero(residual.size());
  VectorXd r = residual;
  VectorXd z = r.cwiseQuotient(diagonal);
  VectorXd p = z;
  VectorXd q;
  double rz = r.dot(z);
  const double enough = kTolerance * kTolerance * rz;
  for (int k = 0; k < kMostIterations && rz > enough; ++k) {
    Multiply(p, q);
    const double alpha = rz / p.dot(q);
    step += alpha * p;
    r -= alpha * q;
    z = r.cwiseQuotient(diagonal);
    const double next = r.dot(z);
    p = z + next / rz * p;
    rz = next;
  }
}

double Corotational::Step(const Vector3d& centre) {
  VectorXd residual = VectorXd::Zero(position_.size());
  Assemble(residual);
  AddContact(centre, residual);
  const double lift_N = contact_.ForceOnBall().z();
  for (std::size_t n = 0; n < held_.size(); ++n) {
    if (held_[n]) residual.segment<3>(3 * static_cast<Eigen::Index>(n)).setZero();
  }
  VectorXd step;
  ConjugateGradients(residual, step);
  position_ += step;
  return lift_N;
}

}  // namespace omni::bench
