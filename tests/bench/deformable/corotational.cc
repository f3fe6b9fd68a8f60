#include "tests/bench/deformable/corotational.h"

#include <Eigen/LU>

namespace omni::bench {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kCuts = 6;              // samples along a surface triangle's edge
constexpr double kReach_balls = 1.5;  // triangles farther from the ball than this are not sampled
constexpr double kTolerance = 1e-3;
constexpr int kMostIterations = 200;

// Rotation of F, warm-started   [Mueller, Bender, Chentanez & Macklin 2016]
void ExtractRotation(const Matrix3d& f, Eigen::Quaterniond& q) {
  for (int k = 0; k < 4; ++k) {
    const Matrix3d r = q.toRotationMatrix();
    Vector3d omega = Vector3d::Zero();
    double down = 1e-9;
    for (int c = 0; c < 3; ++c) {
      omega += r.col(c).cross(f.col(c));
      down += r.col(c).dot(f.col(c));
    }
    omega /= std::abs(down);
    const double angle = omega.norm();
    if (angle < 1e-9) return;
    q = Eigen::Quaterniond(Eigen::AngleAxisd(angle, omega / angle)) * q;
    q.normalize();
  }
}

}  // namespace

Corotational::Corotational(const haptics::TetLattice& lattice, double modulus_Pa, double nu, double clamp_m)
    : penalty_(300 * modulus_Pa / 0.005), surface_(lattice.surface) {
  const double mu = modulus_Pa / (2 * (1 + nu));
  const double lambda = modulus_Pa * nu / ((1 + nu) * (1 - 2 * nu));
  for (const haptics::Vec3& v : lattice.vertices_base_m) {
    rest_.emplace_back(v.x, v.y, v.z);
    held_.push_back(v.z < clamp_m);
  }
  position_.resize(3 * static_cast<Eigen::Index>(rest_.size()));
  for (std::size_t n = 0; n < rest_.size(); ++n) position_.segment<3>(3 * static_cast<Eigen::Index>(n)) = rest_[n];
  for (const auto& tet : lattice.tets) {
    Element e{tet, {}, Matrix12::Zero(), Matrix12::Zero(), Eigen::Quaterniond::Identity()};
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
}

// f = R k (R^T x - x0); k is turned for the tick's matrix.
void Corotational::Rotate(VectorXd& residual) {
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
    for (int a = 0; a < 4; ++a) {
      residual.segment<3>(3 * e.node[static_cast<std::size_t>(a)]) -= r * force.segment<3>(3 * a);
      for (int b = 0; b < 4; ++b) {
        e.turned.block<3, 3>(3 * a, 3 * b) = r * e.rest.block<3, 3>(3 * a, 3 * b) * r.transpose();
      }
    }
  }
}

double Corotational::AddContact(const Vector3d& centre, double radius_m, VectorXd& residual) {
  touches_.clear();
  double lift_N = 0;
  for (const auto& t : surface_) {
    const Vector3d x[3] = {position_.segment<3>(3 * t[0]), position_.segment<3>(3 * t[1]),
                           position_.segment<3>(3 * t[2])};
    const Vector3d middle = (x[0] + x[1] + x[2]) / 3;
    if ((middle - centre).norm() > kReach_balls * radius_m + (x[0] - middle).norm()) continue;
    const double area = 0.5 * (rest_[t[1]] - rest_[t[0]]).cross(rest_[t[2]] - rest_[t[0]]).norm() / (kCuts * kCuts);
    for (int i = 0; i < kCuts; ++i) {
      for (int j = 0; i + j < kCuts; ++j) {
        for (const double third : {1.0 / 3, 2.0 / 3}) {
          if (third > 0.5 && i + j >= kCuts - 1) continue;
          Vector3d w((i + third) / kCuts, (j + third) / kCuts, 0);
          w[2] = 1 - w[0] - w[1];
          const Vector3d away = w[0] * x[0] + w[1] * x[1] + w[2] * x[2] - centre;
          const double inside = radius_m - away.norm();
          if (!(inside > 0)) continue;
          const Vector3d n = away.normalized();
          touches_.push_back({t, w, n, penalty_ * area});
          for (int k = 0; k < 3; ++k) {
            residual.segment<3>(3 * t[static_cast<std::size_t>(k)]) += penalty_ * area * inside * w[k] * n;
          }
          lift_N -= penalty_ * area * inside * n.z();
        }
      }
    }
  }
  return lift_N;
}

void Corotational::Multiply(const VectorXd& x, VectorXd& y) const {
  y.setZero(x.size());
  for (const Element& e : elements_) {
    Eigen::Matrix<double, 12, 1> local;
    for (int a = 0; a < 4; ++a) local.segment<3>(3 * a) = x.segment<3>(3 * e.node[static_cast<std::size_t>(a)]);
    const Eigen::Matrix<double, 12, 1> force = e.turned * local;
    for (int a = 0; a < 4; ++a) y.segment<3>(3 * e.node[static_cast<std::size_t>(a)]) += force.segment<3>(3 * a);
  }
  for (const Touch& t : touches_) {
    double along = 0;
    for (int k = 0; k < 3; ++k)
      along += t.weights[k] * t.normal.dot(x.segment<3>(3 * t.node[static_cast<std::size_t>(k)]));
    for (int k = 0; k < 3; ++k) {
      y.segment<3>(3 * t.node[static_cast<std::size_t>(k)]) += t.stiffness * along * t.weights[k] * t.normal;
    }
  }
  for (std::size_t n = 0; n < held_.size(); ++n) {
    if (held_[n]) y.segment<3>(3 * static_cast<Eigen::Index>(n)).setZero();
  }
}

void Corotational::ConjugateGradients(const VectorXd& residual, VectorXd& step) const {
  VectorXd diagonal = VectorXd::Zero(residual.size());
  for (const Element& e : elements_) {
    for (int a = 0; a < 12; ++a) diagonal[3 * e.node[static_cast<std::size_t>(a / 3)] + a % 3] += e.turned(a, a);
  }
  for (const Touch& t : touches_) {
    for (int a = 0; a < 9; ++a) {
      diagonal[3 * t.node[static_cast<std::size_t>(a / 3)] + a % 3] +=
          t.stiffness * t.weights[a / 3] * t.weights[a / 3] * t.normal[a % 3] * t.normal[a % 3];
    }
  }
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

double Corotational::Step(const Vector3d& centre, double radius_m) {
  VectorXd residual = VectorXd::Zero(position_.size());
  Rotate(residual);
  const double lift_N = AddContact(centre, radius_m, residual);
  for (std::size_t n = 0; n < held_.size(); ++n) {
    if (held_[n]) residual.segment<3>(3 * static_cast<Eigen::Index>(n)).setZero();
  }
  VectorXd step;
  ConjugateGradients(residual, step);
  position_ += step;
  return lift_N;
}

}  // namespace omni::bench
