#include "tests/bench/deformable/off_axis.h"

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>

#include "tests/bench/deformable/ring_solver.h"

namespace omni::bench {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kAsidePenalty = 4e3;
constexpr double kAsideStep = 0.08;  // of the ball's radius
constexpr int kAsideNewtonSteps = 30;
constexpr int kContactPoints = 10;  // along an element's edge under the ball
constexpr double kFineRings_balls = 0.3;
constexpr double kNearRings_balls = 1.1;  // rings are circles up to here, then they take the body's outline

std::size_t Z(Index i) { return static_cast<std::size_t>(i); }

struct GaussPoint {
  double at, weight;  // in [-1, 1]
};

// Newton on Legendre's polynomials.
std::vector<GaussPoint> GaussLegendre(int n) {
  std::vector<GaussPoint> points;
  for (int k = 0; k < n; ++k) {
    double x = std::cos(std::numbers::pi * (k + 0.75) / (n + 0.5));
    double slope = 1;
    for (int step = 0; step < 50; ++step) {
      double last = 1, p = x;
      for (int m = 2; m <= n; ++m) {
        const double next = ((2 * m - 1) * x * p - (m - 1) * last) / m;
        last = p;
        p = next;
      }
      slope = n * (x * p - last) / (x * x - 1);
      x -= p / slope;
      if (std::abs(p / slope) < 1e-15) break;
    }
    points.push_back({x, 2 / ((1 - x * x) * slope * slope)});
  }
  return points;
}

// Values and derivatives of the three quadratic shapes at -1, 0, 1.
struct Quadratic {
  std::array<double, 3> value, slope;
  explicit Quadratic(double s)
      : value{0.5 * s * (s - 1), 1 - s * s, 0.5 * s * (s + 1)}, slope{s - 0.5, -2 * s, s + 0.5} {}
};

// 0 ... 1 in edges that grow from `first` on.
std::vector<double> GrowingShares(double first, double growth) {
  std::vector<double> x{0};
  for (double step = first; x.back() < 1; step *= growth) x.push_back(x.back() + step);
  const double last = x.back();
  for (double& v : x) v /= last;
  return x;
}

// Map from ring coordinates to the body at rest: x aside, y across the mirror, z up.
class AsideMap {
 public:
  AsideMap(const AxisBody& body, double aside, double ball, const SolidMesh& mesh) : body_(body), aside_(aside) {
    const double near = std::min(kNearRings_balls * ball, 0.7 * (body.radius_m - aside));
    double step = mesh.finest_m;
    radius_.push_back(0);
    while (radius_.back() < near) {
      if (radius_.back() > kFineRings_balls * ball) step *= std::sqrt(mesh.growth);
      radius_.push_back(radius_.back() + step);
    }
    near_ = radius_.back();
    share_.assign(radius_.size(), 0);
    const std::vector<double> outer = GrowingShares(step * mesh.growth / (body.radius_m - near_), mesh.growth);
    for (std::size_t k = 1; k < outer.size(); ++k) {
      radius_.push_back(near_);
      share_.push_back(outer[k]);
    }
    down_ = GrowingShares(mesh.finest_m / body.height_m, mesh.growth);
  }

  int rings() const { return static_cast<int>(radius_.size()) - 1; }
  int layers() const { return static_cast<int>(down_.size()) - 1; }

  struct Spot {
    Vector3d at;
    Matrix3d tangent;  // columns: by s (distance), t (depth), phi
  };
  // s, t in [-1, 1] of the element.
  Spot At(int ring, int layer, double s, double t, double phi) const {
    const std::size_t e = Z(ring), f = Z(layer);
    // Distance to the outline: |aside e_x + rho (cos, sin)| = radius.
    const double sine = std::sin(phi), cosine = std::cos(phi);
    const double root = std::sqrt(body_.radius_m * body_.radius_m - aside_ * aside_ * sine * sine);
    const double far = root - aside_ * cosine - near_;
    const double far_phi = aside_ * sine - aside_ * aside_ * sine * cosine / root;
    const double half = 0.5 * (1 - s), rest = 0.5 * (1 + s);
    const double share = half * share_[e] + rest * share_[e + 1];
    const double rho = half * radius_[e] + rest * radius_[e + 1] + share * far;
    const double rho_s = 0.5 * (radius_[e + 1] - radius_[e] + (share_[e + 1] - share_[e]) * far);
    const double rho_phi = share * far_phi;
    const double left = 1 - 0.5 * ((1 - t) * down_[f] + (1 + t) * down_[f + 1]);
    const double left_t = -0.5 * (down_[f + 1] - down_[f]);
    const Eigen::Vector2d p(aside_ + rho * cosine, rho * sine);
    const Eigen::Vector2d p_s(rho_s * cosine, rho_s * sine);
    const Eigen::Vector2d p_phi(rho_phi * cosine - rho * sine, rho_phi * sine + rho * cosine);
    const double r = std::max(p.norm(), 1e-12);
    const double top = body_.Top(std::min(r, body_.radius_m)), slope = body_.TopSlope(std::min(r, body_.radius_m));
    Spot spot;
    spot.at = {p.x(), p.y(), top * left};
    spot.tangent.col(0) = Vector3d(p_s.x(), p_s.y(), slope * p.dot(p_s) / r * left);
    spot.tangent.col(1) = Vector3d(0, 0, top * left_t);
    spot.tangent.col(2) = Vector3d(p_phi.x(), p_phi.y(), slope * p.dot(p_phi) / r * left);
    return spot;
  }

 private:
  const AxisBody& body_;
  double aside_, near_ = 0;
  std::vector<double> radius_, share_;  // of ring edges: radius + share x (outline - near)
  std::vector<double> down_;            // of layer edges, share of the height
};

// Unknowns: 3 Cartesian displacements; x and z in cosines 0 ... M, y in sines 1 ... M, at every node but the base's.
class PressAside {
 public:
  PressAside(const AxisBody& body, double aside, double nu, double ball, const SolidMesh& mesh)
      : map_(body, aside, ball, mesh),
        mu_(1 / (2 * (1 + nu))),
        lambda_(nu / ((1 + nu) * (1 - 2 * nu))),
        ball_(ball),
        modes_(mesh.modes),
        angles_(2 * mesh.modes + 4),
        count_{mesh.modes + 1, mesh.modes, mesh.modes + 1},
        line_(2 * map_.layers() * (3 * mesh.modes + 2)),
        solver_(line_) {
    normal_ = Vector3d(-body.TopSlope(aside), 0, 1).normalized();
    top_ = {aside, 0, body.Top(aside)};
    u_ = VectorXd::Zero((2 * map_.rings() + 1) * line_);
    MakeElements();
    MakeContactPoints();
  }

  int nodes() const { return (2 * map_.rings() + 1) * (2 * map_.layers() + 1); }

  bool MoveTo(double depth) {
    double step = kAsideStep * ball_;
    while (depth_ < depth) {
      const VectorXd before = u_;
      const double from = depth_;
      depth_ = std::min(depth, from + step);
      if (Newton()) continue;
      u_ = before;
      depth_ = from;
      step *= 0.5;
      if (step < 1e-3 * kAsideStep * ball_) return false;
    }
    return true;
  }

  double Force() const {
    double force = 0;
    for (const ContactPoint& p : contact_) {
      const Touching t = Touch(u_, p);
      if (t.inside > 0) force -= p.weight * kAsidePenalty / ball_ * t.inside * t.out.dot(normal_);
    }
    return force;
  }

 private:
  using Unknowns = std::vector<Index>;  // of a ring; -1: held
  struct AsideElement {
    int ring, layer;
    std::array<MatrixXd, 2> gradient;  // of cosine and sine shapes: rows 3 point + axis
    VectorXd weight;                   // of the points
    std::array<Unknowns, 3> unknowns;  // by axis, in the order of the gradients
  };
  struct ContactPoint {
    int ring;
    Vector3d at;
    std::array<VectorXd, 2> shape;  // of cosines and sines: of the three top nodes
    double weight;
  };
  struct Touching {
    double inside;
    Vector3d out;
  };

  const MatrixXd& GradientOf(const AsideElement& e, Index axis) const { return e.gradient[axis == 1 ? 1 : 0]; }

  // Cosines 0 ... M or sines 1 ... M, and their derivatives.
  void Around(double phi, std::array<VectorXd, 2>& value, std::array<VectorXd, 2>& slope) const {
    for (const std::size_t kind : {0U, 1U}) {
      value[kind].resize(modes_ + (kind == 0 ? 1 : 0));
      slope[kind].resize(value[kind].size());
      for (Index k = 0; k < value[kind].size(); ++k) {
        const double m = static_cast<double>(k) + (kind == 0 ? 0 : 1);
        value[kind][k] = kind == 0 ? std::cos(m * phi) : std::sin(m * phi);
        slope[kind][k] = kind == 0 ? -m * std::sin(m * phi) : m * std::cos(m * phi);
      }
    }
  }

  double Angle(int k, int count) const { return std::numbers::pi * (k + 0.5) / count; }

  void MakeElements() {
    const std::vector<GaussPoint> gauss = GaussLegendre(3);
    for (int ring = 0; ring < map_.rings(); ++ring) {
      for (int layer = 0; layer < map_.layers(); ++layer) {
        AsideElement e{ring, layer, {}, VectorXd(9 * angles_), {}};
        for (Index axis = 0; axis < 3; ++axis) e.unknowns[Z(axis)] = ListUnknowns(ring, layer, axis, 3);
        e.gradient[0].resize(27 * angles_, 9 * (modes_ + 1));
        e.gradient[1].resize(27 * angles_, 9 * modes_);
        Index point = 0;
        for (const GaussPoint& s : gauss) {
          for (const GaussPoint& t : gauss) {
            for (int k = 0; k < angles_; ++k) FillPoint(s, t, Angle(k, angles_), point++, e);
          }
        }
        elements_.push_back(std::move(e));
      }
    }
  }

  void FillPoint(const GaussPoint& s, const GaussPoint& t, double phi, Index point, AsideElement& e) const {
    const AsideMap::Spot spot = map_.At(e.ring, e.layer, s.at, t.at, phi);
    const Matrix3d turn = spot.tangent.inverse().transpose();
    e.weight[point] = 2 * std::numbers::pi / angles_ * s.weight * t.weight * std::abs(spot.tangent.determinant());
    const Quadratic ns(s.at), nt(t.at);
    std::array<VectorXd, 2> value, slope;
    Around(phi, value, slope);
    for (const std::size_t kind : {0U, 1U}) {
      const Index modes = value[kind].size();
      for (std::size_t a = 0; a < 9; ++a) {
        const std::size_t i = a / 3, j = a % 3;
        for (Index m = 0; m < modes; ++m) {
          const Vector3d by(ns.slope[i] * nt.value[j] * value[kind][m], ns.value[i] * nt.slope[j] * value[kind][m],
                            ns.value[i] * nt.value[j] * slope[kind][m]);
          e.gradient[kind].block<3, 1>(3 * point, static_cast<Index>(a) * modes + m) = turn * by;
        }
      }
    }
  }

  void MakeContactPoints() {
    const std::vector<GaussPoint> gauss = GaussLegendre(kContactPoints);
    const int angles = 2 * angles_;
    for (int ring = 0; ring < map_.rings(); ++ring) {
      top_unknowns_.push_back({ListUnknowns(ring, 0, 0, 1), ListUnknowns(ring, 0, 1, 1), ListUnknowns(ring, 0, 2, 1)});
      for (const GaussPoint& s : gauss) {
        for (int k = 0; k < angles; ++k) {
          const AsideMap::Spot spot = map_.At(ring, 0, s.at, -1, Angle(k, angles));
          if ((spot.at - top_).norm() > 1.5 * ball_) continue;
          ContactPoint p{ring, spot.at, {}, 0};
          p.weight = 2 * std::numbers::pi / angles * s.weight * spot.tangent.col(0).cross(spot.tangent.col(2)).norm();
          std::array<VectorXd, 2> value, slope;
          Around(Angle(k, angles), value, slope);
          const Quadratic n(s.at);
          for (const std::size_t kind : {0U, 1U}) {
            p.shape[kind].resize(3 * value[kind].size());
            for (std::size_t a = 0; a < 3; ++a) {
              p.shape[kind].segment(static_cast<Index>(a) * value[kind].size(), value[kind].size()) =
                  n.value[a] * value[kind];
            }
          }
          contact_.push_back(std::move(p));
        }
      }
    }
  }

  // Unknown of a ring: line 0 ... 2, node down 0 ... 2 layers, axis, mode; -1: held.
  Index RingIndex(int ring, int line, int node, Index axis, Index mode) const {
    if (node >= 2 * map_.layers()) return -1;
    // On the ball's own line a displacement has one value only.
    if (ring == 0 && line == 0 && (axis == 1 || mode > 0)) return -1;
    const Index first = axis == 0 ? 0 : (axis == 1 ? modes_ + 1 : 2 * modes_ + 1);
    return line * line_ + node * (3 * modes_ + 2) + first + mode;
  }

  // Unknowns of an element along `axis`, in the order of its gradients; `nodes` down: 3, or 1 for its top.
  Unknowns ListUnknowns(int ring, int layer, Index axis, int nodes) const {
    Unknowns indices;
    for (int line = 0; line < 3; ++line) {
      for (int j = 0; j < nodes; ++j) {
        for (Index m = 0; m < count_[Z(axis)]; ++m) indices.push_back(RingIndex(ring, line, 2 * layer + j, axis, m));
      }
    }
    return indices;
  }

  VectorXd Gather(const VectorXd& u, int ring, const Unknowns& indices) const {
    VectorXd local(static_cast<Index>(indices.size()));
    for (Index k = 0; k < local.size(); ++k) local[k] = indices[Z(k)] < 0 ? 0 : u[2 * ring * line_ + indices[Z(k)]];
    return local;
  }

  // F - 1 at the points of an element, a column an axis, rows 3 point + derivative.
  Eigen::Matrix<double, Eigen::Dynamic, 3> Strain(const VectorXd& u, const AsideElement& e) const {
    Eigen::Matrix<double, Eigen::Dynamic, 3> h(3 * e.weight.size(), 3);
    for (Index axis = 0; axis < 3; ++axis) {
      h.col(axis) = GradientOf(e, axis) * Gather(u, e.ring, e.unknowns[Z(axis)]);
    }
    return h;
  }

  Touching Touch(const VectorXd& u, const ContactPoint& p) const {
    Vector3d x = p.at;
    for (Index axis = 0; axis < 3; ++axis) {
      x[axis] += p.shape[axis == 1 ? 1 : 0].dot(Gather(u, p.ring, top_unknowns_[Z(p.ring)][Z(axis)]));
    }
    const Vector3d away = x - (top_ + (ball_ - depth_) * normal_);
    return {ball_ - away.norm(), away.normalized()};
  }

  // W = mu/2 (I - 3) - mu ln J + lambda/2 (ln J)^2, by h = F - 1 so that small strains keep their digits.
  double Energy(const VectorXd& u) const {
    double energy = 0;
    for (const AsideElement& e : elements_) {
      const auto strain = Strain(u, e);
      for (Index q = 0; q < e.weight.size(); ++q) {
        const Matrix3d h = strain.block<3, 3>(3 * q, 0).transpose();
        const double minors = 0.5 * (h.trace() * h.trace() - (h * h).trace());
        const double growth = h.trace() + minors + h.determinant();
        const double log_j = growth > -1 ? std::log1p(growth) : std::numeric_limits<double>::quiet_NaN();
        energy +=
            e.weight[q] * (mu_ * (h.trace() - log_j) + 0.5 * mu_ * h.squaredNorm() + 0.5 * lambda_ * log_j * log_j);
      }
    }
    for (const ContactPoint& p : contact_) {
      const double inside = Touch(u, p).inside;
      if (inside > 0) energy += 0.5 * p.weight * kAsidePenalty / ball_ * inside * inside;
    }
    return energy;
  }

  void Linearise(std::vector<MatrixXd>& rings, VectorXd& gradient) const {
    rings.assign(Z(map_.rings()), MatrixXd::Zero(3 * line_, 3 * line_));
    gradient.setZero(u_.size());
    for (const AsideElement& e : elements_) AddElement(e, rings[Z(e.ring)], gradient);
    for (const ContactPoint& p : contact_) AddContact(p, rings[Z(p.ring)], gradient);
    for (Index k = 0; k < line_; ++k) {
      if (rings[0](k, k) == 0) rings[0](k, k) = 1;  // held
    }
  }

  // P = mu (F - F^-T) + lambda ln J F^-T and its derivative.
  void AddElement(const AsideElement& e, MatrixXd& ring, VectorXd& gradient) const {
    const auto strain = Strain(u_, e);
    const Index points = e.weight.size();
    Eigen::Matrix<double, Eigen::Dynamic, 3> stress(3 * points, 3);
    std::vector<Matrix3d> inverse(Z(points));
    VectorXd log_j(points);
    for (Index q = 0; q < points; ++q) {
      const Matrix3d f = Matrix3d::Identity() + strain.block<3, 3>(3 * q, 0).transpose();
      inverse[Z(q)] = f.inverse();
      log_j[q] = std::log(f.determinant());
      const Matrix3d p = mu_ * (f - inverse[Z(q)].transpose()) + lambda_ * log_j[q] * inverse[Z(q)].transpose();
      stress.block<3, 3>(3 * q, 0) = e.weight[q] * p.transpose();
    }
    for (Index i = 0; i < 3; ++i) {
      const Unknowns& rows = e.unknowns[Z(i)];
      Scatter(GradientOf(e, i).transpose() * stress.col(i), e.ring, rows, gradient);
      for (Index k = i; k < 3; ++k) {
        const MatrixXd& g = GradientOf(e, k);
        MatrixXd turned(g.rows(), g.cols());
        for (Index q = 0; q < points; ++q) {
          // dP_iJ / dF_kL = mu delta + (mu - lambda ln J) F^-1_Jk F^-1_Li + lambda F^-1_Ji F^-1_Lk
          const Matrix3d& v = inverse[Z(q)];
          Matrix3d d =
              (mu_ - lambda_ * log_j[q]) * v.col(k) * v.col(i).transpose() + lambda_ * v.col(i) * v.col(k).transpose();
          if (i == k) d.diagonal().array() += mu_;
          turned.middleRows<3>(3 * q).noalias() = (e.weight[q] * d) * g.middleRows<3>(3 * q);
        }
        const MatrixXd block = GradientOf(e, i).transpose() * turned;
        const Unknowns& columns = e.unknowns[Z(k)];
        Scatter(block, rows, columns, ring);
        if (k != i) Scatter(block.transpose(), columns, rows, ring);
      }
    }
  }

  void AddContact(const ContactPoint& p, MatrixXd& ring, VectorXd& gradient) const {
    const Touching t = Touch(u_, p);
    if (!(t.inside > 0)) return;
    const double k = p.weight * kAsidePenalty / ball_;
    // The ball's own curvature is omitted: it is small where forces balance, and elsewhere it would cost definiteness.
    const Matrix3d d = k * t.out * t.out.transpose();
    for (Index i = 0; i < 3; ++i) {
      const VectorXd& n = p.shape[i == 1 ? 1 : 0];
      const Unknowns& rows = top_unknowns_[Z(p.ring)][Z(i)];
      Scatter(-k * t.inside * t.out[i] * n, p.ring, rows, gradient);
      for (Index j = 0; j < 3; ++j) {
        const MatrixXd block = d(i, j) * n * p.shape[j == 1 ? 1 : 0].transpose();
        Scatter(block, rows, top_unknowns_[Z(p.ring)][Z(j)], ring);
      }
    }
  }

  void Scatter(const VectorXd& local, int ring, const Unknowns& rows, VectorXd& all) const {
    for (Index a = 0; a < local.size(); ++a) {
      if (rows[Z(a)] >= 0) all[2 * ring * line_ + rows[Z(a)]] += local[a];
    }
  }

  static void Scatter(const MatrixXd& block, const Unknowns& rows, const Unknowns& columns, MatrixXd& ring) {
    for (Index b = 0; b < block.cols(); ++b) {
      if (columns[Z(b)] < 0) continue;
      for (Index a = 0; a < block.rows(); ++a) {
        if (rows[Z(a)] >= 0) ring(rows[Z(a)], columns[Z(b)]) += block(a, b);
      }
    }
  }

  bool Newton() {
    std::vector<MatrixXd> rings;
    VectorXd gradient;
    for (int step = 0; step < kAsideNewtonSteps; ++step) {
      Linearise(rings, gradient);
      if (!gradient.allFinite() || !solver_.Factor(rings)) return false;
      const VectorXd delta = solver_.Solve(-gradient);
      const double slope = gradient.dot(delta);
      const double energy = Energy(u_);
      if (std::abs(slope) < 1e-8 * energy) {
        u_ += delta;
        return u_.allFinite();
      }
      double share = 1;
      while (share > 1e-4 && !(Energy(u_ + share * delta) <= energy + 1e-4 * share * slope)) share *= 0.5;
      if (share <= 1e-4) return false;
      u_ += share * delta;
    }
    return false;
  }

  AsideMap map_;
  double mu_, lambda_, ball_;
  int modes_, angles_;
  std::array<Index, 3> count_;  // of modes, by axis
  int line_;
  RingSolver solver_;
  double depth_ = 0;
  Vector3d normal_, top_;
  std::vector<AsideElement> elements_;
  std::vector<ContactPoint> contact_;
  std::vector<std::array<Unknowns, 3>> top_unknowns_;  // of every ring
  VectorXd u_;
};

}  // namespace

AxisCurve PressBallAside(const AxisBody& body, double aside_m, double poisson_ratio, double ball_radius_m,
                         const std::vector<double>& depths_m, const SolidMesh& mesh) {
  PressAside press(body, aside_m, poisson_ratio, ball_radius_m, mesh);
  AxisCurve curve;
  curve.nodes = press.nodes();
  for (const double depth : depths_m) {
    curve.converged = curve.converged && press.MoveTo(depth);
    curve.force_per_modulus_m2.push_back(press.Force());
  }
  return curve;
}

}  // namespace omni::bench
