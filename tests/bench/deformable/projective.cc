#include "tests/bench/deformable/projective.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "tests/bench/deformable/peer_rotation.h"

namespace omni::bench {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

// The nearest matrix of determinant 1: minimise |D - F|, with the constraint linearised in each iteration.
Matrix3d NearestOfVolumeOne(const Matrix3d& f) {
  Matrix3d d = f;
  for (int step = 0; step < 8; ++step) {
    Matrix3d slope;  // of the determinant: its cofactors
    slope.col(0) = d.col(1).cross(d.col(2));
    slope.col(1) = d.col(2).cross(d.col(0));
    slope.col(2) = d.col(0).cross(d.col(1));
    const double off = d.col(0).dot(slope.col(0)) - 1;
    const double along = (slope.cwiseProduct(d - f).sum() - off) / std::max(slope.squaredNorm(), 1e-12);
    const Matrix3d next = f + along * slope;
    const double change = (next - d).squaredNorm();
    d = next;
    if (change < 1e-18) break;
  }
  return d;
}

}  // namespace

Projective::Projective(const haptics::TetLattice& lattice, double modulus_Pa, double nu, double clamp_m,
                       double ball_radius_m)
    : mu_Pa_(modulus_Pa / (2 * (1 + nu))),
      lambda_Pa_(modulus_Pa * nu / ((1 + nu) * (1 - 2 * nu))),
      ball_radius_m_(ball_radius_m),
      contact_(lattice, modulus_Pa, ball_radius_m) {
  position_.resize(3 * static_cast<Index>(lattice.vertices_base_m.size()));
  for (std::size_t n = 0; n < lattice.vertices_base_m.size(); ++n) {
    const haptics::Vec3& v = lattice.vertices_base_m[n];
    position_.segment<3>(3 * static_cast<Index>(n)) = Vector3d(v.x, v.y, v.z);
    column_.push_back(v.z < clamp_m ? -1 : free_++);
  }
  for (const auto& tet : lattice.tets) {
    Matrix3d edges;
    const auto at = [&](std::size_t k) { return position_.segment<3>(3 * static_cast<Index>(tet[k])); };
    for (int c = 0; c < 3; ++c) edges.col(c) = at(static_cast<std::size_t>(c + 1)) - at(0);
    const Matrix3d inverse = edges.inverse();
    ProjectiveTet e{tet, {}, edges.determinant() / 6, Eigen::Quaterniond::Identity()};
    e.gradient[0].setZero();
    for (int c = 0; c < 3; ++c) {
      e.gradient[static_cast<std::size_t>(c + 1)] = inverse.row(c).transpose();
      e.gradient[0] -= inverse.row(c).transpose();
    }
    elements_.push_back(e);
  }
  AssembleRest();
  solver_.analyzePattern(rest_);
  Refactor();
}

// One number per pair of nodes: the three coordinates share the matrix.
void Projective::AssembleRest() {
  std::vector<Eigen::Triplet<double>> entries;
  for (const ProjectiveTet& e : elements_) {
    for (std::size_t a = 0; a < 4; ++a) {
      const Index row = column_[e.node[a]];
      if (row < 0) continue;
      for (std::size_t b = 0; b < 4; ++b) {
        const double k = e.volume_m3 * (2 * mu_Pa_ + 3 * lambda_Pa_) * e.gradient[a].dot(e.gradient[b]);
        const Index column = column_[e.node[b]];
        if (column < 0) {
          anchors_.push_back({row, static_cast<Index>(e.node[b]), k});
        } else {
          entries.emplace_back(static_cast<int>(row), static_cast<int>(column), k);
        }
      }
    }
  }
  rest_.resize(free_, free_);
  rest_.setFromTriplets(entries.begin(), entries.end());
}

// Samples of the surface couple nodes of one triangle only: the pattern stays.
void Projective::Refactor() {
  Sparse matrix = rest_;
  for (const PeerTouch& t : touches_) {
    for (std::size_t a = 0; a < 3; ++a) {
      for (std::size_t b = 0; b < 3; ++b) {
        matrix.coeffRef(column_[t.node[a]], column_[t.node[b]]) +=
            t.stiffness_N_m * t.weights[static_cast<Index>(a)] * t.weights[static_cast<Index>(b)];
      }
    }
  }
  solver_.factorize(matrix);
}

// Right side of the global step: the tetrahedra's target positions of their nodes.
Eigen::Matrix<double, Eigen::Dynamic, 3> Projective::Project() {
  Eigen::Matrix<double, Eigen::Dynamic, 3> right(free_, 3);
  right.setZero();
  for (ProjectiveTet& e : elements_) {
    Matrix3d f = Matrix3d::Zero();
    for (std::size_t a = 0; a < 4; ++a) {
      f += position_.segment<3>(3 * static_cast<Index>(e.node[a])) * e.gradient[a].transpose();
    }
    ExtractRotation(f, e.rotation);
    const Matrix3d goal =
        e.volume_m3 * (2 * mu_Pa_ * e.rotation.toRotationMatrix() + 3 * lambda_Pa_ * NearestOfVolumeOne(f));
    for (std::size_t a = 0; a < 4; ++a) {
      if (column_[e.node[a]] >= 0) right.row(column_[e.node[a]]) += (goal * e.gradient[a]).transpose();
    }
  }
  for (const Anchor& anchor : anchors_) {
    right.row(anchor.row) -= anchor.entry * position_.segment<3>(3 * anchor.held).transpose();
  }
  return right;
}

void Projective::Iterate(const Vector3d& centre) {
  Eigen::Matrix<double, Eigen::Dynamic, 3> right = Project();
  for (const PeerTouch& t : touches_) {
    Vector3d x = Vector3d::Zero();
    for (std::size_t k = 0; k < 3; ++k) {
      x += t.weights[static_cast<Index>(k)] * position_.segment<3>(3 * static_cast<Index>(t.node[k]));
    }
    const Vector3d goal = centre + ball_radius_m_ * (x - centre).normalized();
    for (std::size_t k = 0; k < 3; ++k) {
      const double weight = t.stiffness_N_m * t.weights[static_cast<Index>(k)];
      right.row(column_[t.node[k]]) += weight * goal.transpose();
    }
  }
  const Eigen::Matrix<double, Eigen::Dynamic, 3> x = solver_.solve(right);
  for (std::size_t n = 0; n < column_.size(); ++n) {
    if (column_[n] >= 0) position_.segment<3>(3 * static_cast<Index>(n)) = x.row(column_[n]).transpose();
  }
}

double Projective::Step(const Vector3d& centre) {
  touches_ = contact_.Find(position_, centre);
  std::erase_if(touches_, [this](const PeerTouch& t) {
    return std::any_of(t.node.begin(), t.node.end(), [this](std::uint32_t n) { return column_[n] < 0; });
  });
  Refactor();
  for (int k = 0; k < kIterations; ++k) Iterate(centre);
  contact_.Find(position_, centre);
  return contact_.ForceOnBall().z();
}

}  // namespace omni::bench
