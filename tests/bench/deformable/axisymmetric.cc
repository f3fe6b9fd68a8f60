#include "tests/bench/deformable/axisymmetric.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <cmath>
#include <limits>
#include <numbers>

namespace omni::bench {
namespace {

using Eigen::Vector2d;
using Sparse = Eigen::SparseMatrix<double>;

constexpr double kPenalty = 2e4;
constexpr double kLargestStep = 0.08;  // of the ball's radius
constexpr int kNewtonSteps = 40;
constexpr double kGauss = 0.57735026918962576;

// 0 ... length: edges of `finest` up to `fine_until`, growing beyond.
std::vector<double> GradedLine(double length, double finest, double fine_until, double growth) {
  std::vector<double> x{0};
  double step = finest;
  while (x.back() < length) {
    if (x.back() > fine_until) step *= growth;
    x.push_back(x.back() + step);
  }
  const double scale = length / x.back();
  for (double& v : x) v *= scale;
  return x;
}

class Press {
 public:
  Press(const AxisBody& body, double nu, double ball, const AxisMesh& mesh)
      : mu_(1 / (2 * (1 + nu))), lambda_(nu / ((1 + nu) * (1 - 2 * nu))), ball_(ball) {
    const std::vector<double> r = GradedLine(body.radius_m, mesh.finest_m, 0.9 * ball, mesh.growth);
    const std::vector<double> down = GradedLine(body.height_m, mesh.finest_m, 0.6 * ball, mesh.growth);
    columns_ = static_cast<int>(r.size());
    rows_ = static_cast<int>(down.size());
    top_m_ = body.height_m;
    for (const double d : down) {
      for (const double x : r) rest_.emplace_back(x, body.Top(x) * (1 - d / body.height_m));
    }
    u_ = Eigen::VectorXd::Zero(2 * static_cast<Eigen::Index>(rest_.size()));
  }

  int nodes() const { return static_cast<int>(rest_.size()); }

  // Moves the ball to `depth` in small steps, smaller where Newton does not converge; false: too small.
  bool MoveTo(double depth) {
    double step = kLargestStep * ball_;
    while (depth_ < depth) {
      const Eigen::VectorXd before = u_;
      const double from = depth_;
      depth_ = std::min(depth, from + step);
      if (Newton()) continue;
      u_ = before;
      depth_ = from;
      step *= 0.5;
      if (step < 1e-4 * kLargestStep * ball_) return false;
    }
    return true;
  }

  void ReadTop(AxisCurve& curve) const {
    for (int i = 0; i < columns_; ++i) {
      curve.top_r_m.push_back(rest_[static_cast<std::size_t>(i)].x());
      curve.top_fall_m.push_back(-u_[2 * i + 1]);
    }
  }

  double Force() const {
    double force = 0;
    ForContact(u_, [&](double weight, double inside, const Vector2d& out, const Vector2d&, int) {
      force -= weight * kPenalty / ball_ * inside * out.y();
    });
    return force;
  }

 private:
  bool Fixed(int dof) const {
    const int node = dof / 2;
    if (dof % 2 == 0 && node % columns_ == 0) return true;  // the axis
    return node / columns_ == rows_ - 1;                    // the base
  }

  Vector2d Position(const Eigen::VectorXd& u, int node) const {
    return rest_[static_cast<std::size_t>(node)] + u.segment<2>(2 * node);
  }

  // visit(weight, depth inside the ball, direction out of the ball, shape values, first node)
  template <class Visit>
  void ForContact(const Eigen::VectorXd& u, Visit&& visit) const {
    const Vector2d centre(0, top_m_ + ball_ - depth_);
    for (int i = 0; i + 1 < columns_; ++i) {
      const Vector2d edge = rest_[static_cast<std::size_t>(i + 1)] - rest_[static_cast<std::size_t>(i)];
      for (const double g : {-kGauss, kGauss}) {
        const Vector2d n(0.5 * (1 - g), 0.5 * (1 + g));
        const Vector2d x = n[0] * Position(u, i) + n[1] * Position(u, i + 1);
        const Vector2d away = x - centre;
        const double inside = ball_ - away.norm();
        if (!(inside > 0)) continue;
        const double r =
            n[0] * rest_[static_cast<std::size_t>(i)].x() + n[1] * rest_[static_cast<std::size_t>(i + 1)].x();
        visit(std::numbers::pi * r * edge.norm(), inside, Vector2d(away.normalized()), n, i);
      }
    }
  }

  // The four quadrature points of every element: gradients of the shapes, F, weight.
  struct Point {
    std::array<int, 4> node;
    Eigen::Matrix<double, 5, 8> b;  // dF (11 12 21 22 33) by displacements
    double weight;
  };
  template <class Visit>
  void ForPoints(Visit&& visit) const {
    for (int j = 0; j + 1 < rows_; ++j) {
      for (int i = 0; i + 1 < columns_; ++i) {
        Point p{{j * columns_ + i, (j + 1) * columns_ + i, (j + 1) * columns_ + i + 1, j * columns_ + i + 1}, {}, 0};
        for (const double s : {-kGauss, kGauss}) {
          for (const double t : {-kGauss, kGauss}) {
            Fill(s, t, p);
            visit(p);
          }
        }
      }
    }
  }

  void Fill(double s, double t, Point& p) const {
    const Eigen::Vector4d n(0.25 * (1 - s) * (1 - t), 0.25 * (1 + s) * (1 - t), 0.25 * (1 + s) * (1 + t),
                            0.25 * (1 - s) * (1 + t));
    Eigen::Matrix<double, 4, 2> dn;
    dn << -(1 - t), -(1 - s), (1 - t), -(1 + s), (1 + t), (1 + s), -(1 + t), (1 - s);
    dn *= 0.25;
    Eigen::Matrix2d jacobian = Eigen::Matrix2d::Zero();
    double r = 0;
    for (int a = 0; a < 4; ++a) {
      const Vector2d& x = rest_[static_cast<std::size_t>(p.node[static_cast<std::size_t>(a)])];
      jacobian += x * dn.row(a);
      r += n[a] * x.x();
    }
    const Eigen::Matrix<double, 4, 2> g = dn * jacobian.inverse();
    p.b.setZero();
    for (int a = 0; a < 4; ++a) {
      p.b(0, 2 * a) = g(a, 0);
      p.b(1, 2 * a) = g(a, 1);
      p.b(2, 2 * a + 1) = g(a, 0);
      p.b(3, 2 * a + 1) = g(a, 1);
      p.b(4, 2 * a) = n[a] / r;
    }
    p.weight = 2 * std::numbers::pi * r * std::abs(jacobian.determinant());
  }

  Eigen::Matrix<double, 8, 1> Local(const Eigen::VectorXd& u, const Point& p) const {
    Eigen::Matrix<double, 8, 1> local;
    for (std::size_t a = 0; a < 4; ++a) local.segment<2>(2 * static_cast<int>(a)) = u.segment<2>(2 * p.node[a]);
    return local;
  }

  static Eigen::Matrix3d GradientOf(const Eigen::Matrix<double, 5, 1>& f) {
    Eigen::Matrix3d full = Eigen::Matrix3d::Identity();
    full(0, 0) += f[0];
    full(0, 1) += f[1];
    full(1, 0) += f[2];
    full(1, 1) += f[3];
    full(2, 2) += f[4];
    return full;
  }

  double Energy(const Eigen::VectorXd& u) const {
    double energy = 0;
    ForPoints([&](const Point& p) {
      // By h = F - 1, because far away it is tiny: I - 3 = 2 tr h + |h|^2, J - 1 = tr h + minors + det.
      const Eigen::Matrix<double, 5, 1> h = p.b * Local(u, p);
      const double trace = h[0] + h[3] + h[4];
      const double minor = h[0] * h[3] - h[1] * h[2];
      const double growth = trace + minor + (h[0] + h[3]) * h[4] + minor * h[4];
      const double log_j = growth > -1 ? std::log1p(growth) : std::numeric_limits<double>::quiet_NaN();
      energy += p.weight * (mu_ * (trace - log_j) + 0.5 * mu_ * h.squaredNorm() + 0.5 * lambda_ * log_j * log_j);
    });
    ForContact(u, [&](double weight, double inside, const Vector2d&, const Vector2d&, int) {
      energy += 0.5 * weight * kPenalty / ball_ * inside * inside;
    });
    return energy;
  }

  void Add(const std::array<int, 4>& nodes, int count, const Eigen::MatrixXd& k, const Eigen::VectorXd& g,
           std::vector<Eigen::Triplet<double>>& entries, Eigen::VectorXd& gradient) const {
    for (int a = 0; a < 2 * count; ++a) {
      const int row = 2 * nodes[static_cast<std::size_t>(a / 2)] + a % 2;
      if (Fixed(row)) continue;
      gradient[row] += g[a];
      for (int b = 0; b < 2 * count; ++b) {
        const int column = 2 * nodes[static_cast<std::size_t>(b / 2)] + b % 2;
        if (!Fixed(column) && row >= column) entries.emplace_back(row, column, k(a, b));
      }
    }
  }

  // P = mu (F - F^-T) + lambda ln J F^-T and its derivative.
  void Linearise(Sparse& matrix, Eigen::VectorXd& gradient) const {
    constexpr int kPair[5][2] = {{0, 0}, {0, 1}, {1, 0}, {1, 1}, {2, 2}};
    std::vector<Eigen::Triplet<double>> entries;
    entries.reserve(rest_.size() * 4 * 36);
    gradient.setZero(u_.size());
    ForPoints([&](const Point& p) {
      const Eigen::Matrix3d f = GradientOf(p.b * Local(u_, p));
      const Eigen::Matrix3d inverse = f.inverse();
      const double log_j = std::log(f.determinant());
      Eigen::Matrix<double, 5, 1> stress;
      Eigen::Matrix<double, 5, 5> tangent;
      for (int a = 0; a < 5; ++a) {
        const auto [i, j] = kPair[a];
        stress[a] = mu_ * (f(i, j) - inverse(j, i)) + lambda_ * log_j * inverse(j, i);
        for (int b = 0; b < 5; ++b) {
          const auto [k, l] = kPair[b];
          tangent(a, b) = (a == b ? mu_ : 0) + (mu_ - lambda_ * log_j) * inverse(j, k) * inverse(l, i) +
                          lambda_ * inverse(j, i) * inverse(l, k);
        }
      }
      Add(p.node, 4, p.weight * (p.b.transpose() * tangent * p.b), p.weight * (p.b.transpose() * stress), entries,
          gradient);
    });
    const double stiffness = kPenalty / ball_;
    ForContact(u_, [&](double weight, double inside, const Vector2d& out, const Vector2d& n, int first) {
      Eigen::Matrix<double, 4, 1> g;
      g << -n[0] * out, -n[1] * out;  // of `inside`
      const double distance = ball_ - inside;
      const Eigen::Matrix2d bend = (Eigen::Matrix2d::Identity() - out * out.transpose()) / distance;
      Eigen::Matrix4d k = g * g.transpose();
      for (int a = 0; a < 2; ++a) {
        for (int b = 0; b < 2; ++b) k.block<2, 2>(2 * a, 2 * b) -= inside * n[a] * n[b] * bend;
      }
      Add({first, first + 1, 0, 0}, 2, weight * stiffness * k, weight * stiffness * inside * g, entries, gradient);
    });
    for (int d = 0; d < static_cast<int>(u_.size()); ++d) {
      if (Fixed(d)) entries.emplace_back(d, d, 1.0);
    }
    matrix.resize(u_.size(), u_.size());
    matrix.setFromTriplets(entries.begin(), entries.end());
  }

  bool Newton() {
    Sparse matrix;
    Eigen::VectorXd gradient;
    for (int step = 0; step < kNewtonSteps; ++step) {
      Linearise(matrix, gradient);
      if (!analysed_) solver_.analyzePattern(matrix);
      analysed_ = true;
      solver_.factorize(matrix);
      if (solver_.info() != Eigen::Success) return false;
      const Eigen::VectorXd delta = solver_.solve(-gradient);
      const double slope = gradient.dot(delta);
      const double energy = Energy(u_);
      if (std::abs(slope) < 1e-11 * (std::abs(energy) + 1e-18)) return true;
      double share = 1;
      while (share > 1e-6 &&
             !(Energy(u_ + share * delta) <= energy + 1e-4 * share * std::min(slope, 0.0) + 1e-14 * std::abs(energy))) {
        share *= 0.5;
      }
      u_ += share * delta;
      if (!u_.allFinite()) return false;
      if (share <= 1e-6) return std::abs(slope) < 1e-8 * std::abs(energy);
    }
    return false;
  }

  double mu_, lambda_, ball_;
  int columns_ = 0, rows_ = 0;
  double top_m_ = 0;
  double depth_ = 0;
  bool analysed_ = false;
  std::vector<Vector2d> rest_;
  Eigen::VectorXd u_;
  Eigen::SimplicialLDLT<Sparse> solver_;
};

}  // namespace

double AxisBody::Top(double r_m) const {
  if (cap_curvature_1_m == 0) return height_m;
  const double cap = 1 / cap_curvature_1_m;
  return height_m - cap + std::copysign(std::sqrt(cap * cap - r_m * r_m), cap);
}

double AxisBody::TopSlope(double r_m) const {
  const double c = cap_curvature_1_m;
  return -c * r_m / std::sqrt(1 - c * c * r_m * r_m);
}

AxisCurve PressBall(const AxisBody& body, double poisson_ratio, double ball_radius_m,
                    const std::vector<double>& depths_m, const AxisMesh& mesh) {
  Press press(body, poisson_ratio, ball_radius_m, mesh);
  AxisCurve curve;
  curve.nodes = press.nodes();
  for (const double depth : depths_m) {
    curve.converged = curve.converged && press.MoveTo(depth);
    curve.force_per_modulus_m2.push_back(press.Force());
  }
  press.ReadTop(curve);
  return curve;
}

}  // namespace omni::bench
