#include "service/haptics/deformable/build/elasticity.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <numbers>
#include <string>

namespace omni::haptics {
namespace {

using Matrix3 = Eigen::Matrix3d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

constexpr int kVoigt[3][3] = {{0, 5, 4}, {5, 1, 3}, {4, 3, 2}};
// Of both averages; the integrands are smooth and periodic, the inner one sharper for stiff fibres.
constexpr int kAngles = 20;
constexpr int kInnerAngles = 60;

// Third axis along `z`, any two across it.
Matrix3 FrameAlong(const Vec3& z) {
  const double length = Norm(z);
  const Vec3 c = length > 0 ? (1 / length) * z : Vec3{0, 0, 1};
  const Vec3 a = Normalized(std::abs(c.x) < 0.8 ? Cross(c, Vec3{1, 0, 0}) : Cross(c, Vec3{0, 1, 0}));
  const Vec3 b = Cross(c, a);
  Matrix3 frame;
  frame << a.x, b.x, c.x, a.y, b.y, c.y, a.z, b.z, c.z;
  return frame;
}

// C_ijkl turned into the frame R: sum R_ia R_jb R_kc R_ld C_abcd.
Matrix6 Rotated(const Matrix6& c, const Matrix3& r) {
  Matrix6 k;  // Bond's matrix for stresses
  for (int i = 0; i < 3; ++i) {
    for (int j = i; j < 3; ++j) {
      for (int a = 0; a < 3; ++a) k(kVoigt[i][j], a) = r(i, a) * r(j, a);
      for (int a = 0; a < 3; ++a) {
        const int b = (a + 1) % 3;
        k(kVoigt[i][j], kVoigt[a][b]) = r(i, a) * r(j, b) + r(i, b) * r(j, a);
      }
    }
  }
  return k * c * k.transpose();
}

// (a b)_jk = a_i C_ijkl b_l
Matrix3 Acoustic(const Stiffness6& c, const Eigen::Vector3d& a, const Eigen::Vector3d& b) {
  Matrix3 m = Matrix3::Zero();
  for (int j = 0; j < 3; ++j) {
    for (int k = 0; k < 3; ++k) {
      for (int i = 0; i < 3; ++i) {
        for (int l = 0; l < 3; ++l) {
          m(j, k) += a[i] * c[static_cast<std::size_t>(kVoigt[i][j])][static_cast<std::size_t>(kVoigt[k][l])] * b[l];
        }
      }
    }
  }
  return m;
}

}  // namespace

base::Status CheckModuli(const ElasticModuli& m) {
  if (!(m.young_modulus_Pa >= 1e2 && m.young_modulus_Pa <= 1e9)) {
    return base::Error{"soft body: Young's modulus " + std::to_string(m.young_modulus_Pa) +
                       " Pa is outside [100, 1e9]"};
  }
  if (!(m.poisson_ratio >= 0 && m.poisson_ratio <= 0.49)) {
    return base::Error{"soft body: Poisson's ratio " + std::to_string(m.poisson_ratio) + " is outside [0, 0.49]"};
  }
  if (!(m.fibre_ratio >= 1 && m.fibre_ratio <= 100)) {
    return base::Error{"soft body: fibre ratio " + std::to_string(m.fibre_ratio) + " is outside [1, 100]"};
  }
  return base::Ok{};
}

// Compliance in the fibre's frame (fibre = third axis)   (2.2): S33 = 1 / (r E), S11 = S22 = 1 / E, S13 = S23 = -nu /
// (r E), S12 = -nu / E, shears 2 (1 + nu) / E. Positive definite for r >= 1, nu < 1/2.
Stiffness6 MakeStiffness(const ElasticModuli& moduli, const Vec3& fibre) {
  const double e = moduli.young_modulus_Pa;
  const double nu = moduli.poisson_ratio;
  const double along = e * moduli.fibre_ratio;
  Matrix6 s = Matrix6::Zero();
  s(0, 0) = s(1, 1) = 1 / e;
  s(2, 2) = 1 / along;
  s(0, 1) = s(1, 0) = -nu / e;
  s(0, 2) = s(2, 0) = s(1, 2) = s(2, 1) = -nu / along;
  s(3, 3) = s(4, 4) = s(5, 5) = 2 * (1 + nu) / e;
  const Matrix6 d = Rotated(s.inverse(), FrameAlong(fibre));
  Stiffness6 result{};
  for (int i = 0; i < 6; ++i) {
    for (int j = 0; j < 6; ++j) {
      result[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)] = 0.5 * (d(i, j) + d(j, i));
    }
  }
  return result;
}

// B(t) = 1 / (8 pi^2) int (m m) - (m n)(n n)^-1 (n m) dphi over the circle of unit m, n across t. A unit normal force
// at the origin of the half-space moves the surface point r t by u_n = N . B(t)^-1 N / (8 pi^2 r); isotropic (1 - nu^2)
// / (pi E r). 1 / M = pi <r u_n>, the mean over t in the surface.   (2.3)
double IndentationModulus(const Stiffness6& stiffness, const Vec3& normal) {
  constexpr double kPi = std::numbers::pi;
  const Matrix3 surface = FrameAlong(normal);
  const Eigen::Vector3d up = surface.col(2);
  double mean = 0;
  for (int i = 0; i < kAngles; ++i) {
    const double theta = kPi * i / kAngles;
    const Eigen::Vector3d t = std::cos(theta) * surface.col(0) + std::sin(theta) * surface.col(1);
    const Eigen::Vector3d side = t.cross(up);
    Matrix3 b = Matrix3::Zero();
    for (int j = 0; j < kInnerAngles; ++j) {
      const double phi = kPi * j / kInnerAngles;
      const Eigen::Vector3d m = std::cos(phi) * side + std::sin(phi) * up;
      const Eigen::Vector3d n = -std::sin(phi) * side + std::cos(phi) * up;
      const Matrix3 mn = Acoustic(stiffness, m, n);
      b += Acoustic(stiffness, m, m) - mn * Acoustic(stiffness, n, n).inverse() * mn.transpose();
    }
    b *= 2 * kPi / kInnerAngles / (8 * kPi * kPi);
    mean += up.dot(b.inverse() * up) / (8 * kPi * kPi) / kAngles;
  }
  return 1 / (kPi * mean);
}

}  // namespace omni::haptics
