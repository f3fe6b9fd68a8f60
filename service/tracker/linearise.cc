#include "service/tracker/linearise.h"

#include <cmath>
#include <cstring>

namespace omni::tracker {
namespace {

// Two sensors at a time: what baseline x86-64 has. Widening Lane and kLaneWidth is all that a wider build needs.
using Lane = double __attribute__((vector_size(16)));
constexpr std::size_t kLaneWidth = sizeof(Lane) / sizeof(double);
static_assert(kSensors % kLaneWidth == 0);

struct Lane3 {
  Lane x, y, z;
};
using Vec = std::array<double, 3>;

constexpr double kMu0Over4Pi = 1e-7;

inline Lane Load(const SensorLanes& values, std::size_t first) {
  Lane lane;
  std::memcpy(&lane, values.data() + first, sizeof lane);
  return lane;
}
inline Lane3 Load(const std::array<SensorLanes, 3>& values, std::size_t first) {
  return {Load(values[0], first), Load(values[1], first), Load(values[2], first)};
}
inline Lane Sqrt(Lane v) {
  for (std::size_t i = 0; i < kLaneWidth; ++i) v[i] = std::sqrt(v[i]);
  return v;
}
inline double Sum(Lane v) {
  double sum = 0;
  for (std::size_t i = 0; i < kLaneWidth; ++i) sum += v[i];
  return sum;
}
inline Lane Dot(const Lane3& a, const Lane3& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline Lane Dot(const Vec& a, const Lane3& b) { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }
inline double Dot(const Vec& a, const Vec& b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }

// One image of a tool point in the core (moment, charge, position) with its derivatives by the five parameters.
struct ImageSource {
  Vec position{}, moment{};
  double charge = 0;
  std::array<Vec, kParameters> position_d{}, moment_d{};
  std::array<double, kParameters> charge_d{};
};

// Image of the dipole m at P in a sphere of radius a, n = P/|P|: m' = kappa (a/r)^3 (2 (m.n) n - m) and
// q' = kappa a (m.n)/r^2 at (a/r)^2 P (docs/theory/magnetics.md (10)); derivatives along dP, dm by the product rule.
ImageSource MakeImage(const Model& model, const ToolPoint& point, const PosePoint& pose) {
  const Vec& u = pose.axis_base;
  const Vec& e1 = pose.tangent_1_base;
  const Vec& e2 = pose.tangent_2_base;
  Vec P{}, m{}, n{};
  for (std::size_t i = 0; i < 3; ++i) {
    P[i] = pose.position_base_m[i] + point.ring_1_m * e1[i] + point.ring_2_m * e2[i] + point.axial_m * u[i];
    m[i] = point.moment_Am2 * u[i];
  }
  const double r = std::sqrt(Dot(P, P));
  for (std::size_t i = 0; i < 3; ++i) n[i] = P[i] / r;
  const double mn = Dot(m, n);
  const double ratio = model.core_radius_m / r;
  const double k = model.core_kappa * ratio * ratio * ratio;
  const double charge_scale = model.core_kappa * model.core_radius_m / (r * r);
  ImageSource image;
  image.charge = charge_scale * mn;
  for (std::size_t i = 0; i < 3; ++i) {
    image.position[i] = ratio * ratio * P[i];
    image.moment[i] = k * (2 * mn * n[i] - m[i]);
  }
  for (std::size_t c = 0; c < kParameters; ++c) {
    Vec dP{}, dm{};
    if (c < 3) {
      dP[c] = 1;
    } else {
      // Turning u by e1 carries the ring along: de1 = -u, du = e1.
      const Vec& e = c == 3 ? e1 : e2;
      const double ring = c == 3 ? point.ring_1_m : point.ring_2_m;
      for (std::size_t i = 0; i < 3; ++i) {
        dP[i] = point.axial_m * e[i] - ring * u[i];
        dm[i] = point.moment_Am2 * e[i];
      }
    }
    const double dr_r = Dot(n, dP) / r;
    double dmn = Dot(dm, n);
    Vec dn{};
    for (std::size_t i = 0; i < 3; ++i) dn[i] = dP[i] / r - n[i] * dr_r;
    dmn += Dot(m, dn);
    image.charge_d[c] = charge_scale * (dmn - 2 * mn * dr_r);
    for (std::size_t i = 0; i < 3; ++i) {
      image.position_d[c][i] = ratio * ratio * (dP[i] - 2 * P[i] * dr_r);
      image.moment_d[c][i] = k * (2 * (dmn * n[i] + mn * dn[i]) - dm[i]) - 3 * dr_r * image.moment[i];
    }
  }
  return image;
}

// Field in B at kLaneWidth sensors and its five derivatives.
struct LaneField {
  Lane3 B;
  std::array<Lane3, kParameters> d;
};

// Zonal field of orders 1, 3, 5 about u, seen from s: docs/theory/magnetics.md (4), (6), (7) with the polynomials
// written out in c = cos. Derivative by the tool's position is minus the gradient.
void SetTool(const Model& model, const PosePoint& pose, const Lane3& s, LaneField& out) {
  const Vec& p = pose.position_base_m;
  const Vec& u = pose.axis_base;
  const Lane3 d{s.x - p[0], s.y - p[1], s.z - p[2]};
  const Lane inv_r = 1.0 / Sqrt(Dot(d, d));
  const Lane3 n{d.x * inv_r, d.y * inv_r, d.z * inv_r};
  const Lane c = Dot(u, n);
  const Lane c2 = c * c;
  const Lane ir2 = inv_r * inv_r;
  const Lane A1 = kMu0Over4Pi * model.tool_zonal[0] * (ir2 * inv_r);
  const Lane A3 = kMu0Over4Pi * model.tool_zonal[1] * (ir2 * ir2 * inv_r);
  const Lane A5 = kMu0Over4Pi * model.tool_zonal[2] * (ir2 * ir2 * ir2 * inv_r);
  // P1 = c; P3 = (5 c^3 - 3 c)/2; P5 = (63 c^5 - 70 c^3 + 15 c)/8 and derivatives.
  const Lane P3 = 0.5 * c * (5 * c2 - 3), P3d = 0.5 * (15 * c2 - 3), P3dd = 15 * c;
  const Lane P5 = 0.125 * c * ((63 * c2 - 70) * c2 + 15), P5d = 0.125 * ((315 * c2 - 210) * c2 + 15),
             P5dd = 0.5 * c * (315 * c2 - 105);
  const Lane beta1 = 3 * c, beta3 = 4 * P3 + c * P3d, beta5 = 6 * P5 + c * P5d;
  const Lane beta3d = 5 * P3d + c * P3dd, beta5d = 7 * P5d + c * P5dd;  // beta1' = 3
  const Lane p1 = A1 + A3 * P3d + A5 * P5d;
  const Lane p2 = A3 * P3dd + A5 * P5dd;
  const Lane beta = A1 * beta1 + A3 * beta3 + A5 * beta5;
  const Lane beta_d = 3 * A1 + A3 * beta3d + A5 * beta5d;
  const Lane curvature = A1 * (4 * beta1 + 3 * c) + A3 * (6 * beta3 + c * beta3d) + A5 * (8 * beta5 + c * beta5d);
  out.B = {beta * n.x - p1 * u[0], beta * n.y - p1 * u[1], beta * n.z - p1 * u[2]};

  const std::array<Lane, 3> n_of{n.x, n.y, n.z};
  for (std::size_t k = 0; k < 3; ++k) {
    const Lane along_u = (p2 * u[k] - beta_d * n_of[k]) * inv_r;
    const Lane along_n = (curvature * n_of[k] - beta_d * u[k]) * inv_r;
    out.d[k] = {along_u * u[0] + along_n * n.x, along_u * u[1] + along_n * n.y, along_u * u[2] + along_n * n.z};
  }
  out.d[0].x -= beta * inv_r;
  out.d[1].y -= beta * inv_r;
  out.d[2].z -= beta * inv_r;
  for (std::size_t k = 3; k < 5; ++k) {
    const Vec& e = k == 3 ? pose.tangent_1_base : pose.tangent_2_base;
    const Lane ne = Dot(e, n);
    const Lane along_n = beta_d * ne;
    const Lane along_u = p2 * ne;
    out.d[k] = {along_n * n.x - along_u * u[0] - p1 * e[0], along_n * n.y - along_u * u[1] - p1 * e[1],
                along_n * n.z - along_u * u[2] - p1 * e[2]};
  }
}

// Adds one image: dipole and charge at x', opposite charge at the origin. docs/theory/magnetics.md (11)
// Along a column (dx', dm', dq'), with e = -dx' the change of d = s - x':
//   dB = (3 (m.d)/r^5 + q/r^3) e + 3 (d.e)/r^5 m - dm/r^3 + dq (d/r^3 - s/|s|^3)
//        + [3 (m.e) + 3 (dm.d) - 3 q (d.e) - 15 (m.d)(d.e)/r^2] d/r^5                       (all times mu0/4pi)
void AddImage(const ImageSource& image, const Lane3& s, const Lane3& centre, LaneField& out) {
  const Lane3 d{s.x - image.position[0], s.y - image.position[1], s.z - image.position[2]};
  const Lane inv_r = 1.0 / Sqrt(Dot(d, d));
  const Lane ir2 = inv_r * inv_r;
  const Lane ir3 = kMu0Over4Pi * (ir2 * inv_r);
  const Lane ir5 = 3.0 * (ir3 * ir2);
  const Vec& m = image.moment;
  const double q = image.charge;
  const Lane md = Dot(m, d);
  const Lane along_d = ir5 * md + ir3 * q;
  out.B.x += along_d * d.x - ir3 * m[0] - kMu0Over4Pi * q * centre.x;
  out.B.y += along_d * d.y - ir3 * m[1] - kMu0Over4Pi * q * centre.y;
  out.B.z += along_d * d.z - ir3 * m[2] - kMu0Over4Pi * q * centre.z;
  const Lane five_md = 5 * md * ir2;
  for (std::size_t k = 0; k < kParameters; ++k) {
    const Vec& dx = image.position_d[k];
    const Vec& dm = image.moment_d[k];
    const double dq = image.charge_d[k];
    const Lane de = -Dot(dx, d);
    const Lane column_d = ir5 * (Dot(dm, d) - Dot(m, dx) - (q + five_md) * de) + ir3 * dq;
    const Lane column_m = ir5 * de;
    const double column_centre = kMu0Over4Pi * dq;
    Lane3& column = out.d[k];
    column.x += column_d * d.x + column_m * m[0] - along_d * dx[0] - ir3 * dm[0] - column_centre * centre.x;
    column.y += column_d * d.y + column_m * m[1] - along_d * dx[1] - ir3 * dm[1] - column_centre * centre.y;
    column.z += column_d * d.z + column_m * m[2] - along_d * dx[2] - ir3 * dm[2] - column_centre * centre.z;
  }
}

using Images = std::array<ImageSource, kImageSources>;

Images MakeImages(const Model& model, const PosePoint& pose) {
  Images images;
  for (std::size_t s = 0; s < images.size(); ++s) {
    if (model.tool_points[s].moment_Am2 != 0) images[s] = MakeImage(model, model.tool_points[s], pose);
  }
  return images;
}

LaneField FieldAt(const Model& model, const Images& images, const PosePoint& pose, std::size_t first) {
  const Lane3 s = Load(model.sensor_position_base_m, first);
  const Lane3 centre = Load(model.sensor_over_r3_base, first);
  LaneField field;
  SetTool(model, pose, s, field);
  for (std::size_t i = 0; i < images.size(); ++i) {
    if (model.tool_points[i].moment_Am2 != 0) AddImage(images[i], s, centre, field);
  }
  return field;
}

constexpr std::size_t kCoils = base::kCoilCount;

struct Sums {
  std::array<Lane, 15> JtJ{};  // lower triangle
  std::array<Lane, kParameters> Jtr{};
  std::array<std::array<Lane, kParameters>, kCoils> CtJ{};
  std::array<Lane, kCoils> Ctr{};
  Lane chi2{};
};

void Add(const std::array<Lane, kParameters>& J, Lane r, const Measurement& measurement, std::size_t row,
         std::size_t first, Sums& sums) {
  sums.chi2 += r * r;
  for (std::size_t k = 0, e = 0; k < kParameters; ++k) {
    sums.Jtr[k] += J[k] * r;
    for (std::size_t j = 0; j <= k; ++j) sums.JtJ[e++] += J[k] * J[j];
  }
  for (std::size_t coil = 0; coil < kCoils; ++coil) {
    const Lane C = Load(measurement.coil[3 * row + coil], first);
    sums.Ctr[coil] += C * r;
    for (std::size_t k = 0; k < kParameters; ++k) sums.CtJ[coil][k] += C * J[k];
  }
}

void Reduce(const Sums& sums, NormalEquations& result) {
  result.chi2 = Sum(sums.chi2);
  for (std::size_t k = 0, e = 0; k < kParameters; ++k) {
    result.Jtr[k] = Sum(sums.Jtr[k]);
    for (std::size_t j = 0; j <= k; ++j) {
      result.JtJ[kParameters * k + j] = result.JtJ[kParameters * j + k] = Sum(sums.JtJ[e++]);
    }
  }
}

// Schur complement of the current errors, S = (C^T C + prior)^-1:
//   JtJ - (C^T J)^T S (C^T J),   Jtr - (C^T J)^T S C^T r,   chi2 - (C^T r)^T S C^T r
// which is the same as whitening with diag(sigma^2) + sum_j s_j^2 a_j a_j^T (docs/theory/tracking.md (4)).
void EliminateCurrents(const Measurement& measurement, const Sums& sums, NormalEquations& result) {
  std::array<double, kCoils> Ctr{};
  std::array<std::array<double, kParameters>, kCoils> CtJ{};
  for (std::size_t c = 0; c < kCoils; ++c) {
    Ctr[c] = Sum(sums.Ctr[c]);
    for (std::size_t k = 0; k < kParameters; ++k) CtJ[c][k] = Sum(sums.CtJ[c][k]);
  }
  for (std::size_t a = 0; a < kCoils; ++a) {
    double S_Ctr = 0;
    std::array<double, kParameters> S_CtJ{};
    for (std::size_t b = 0; b < kCoils; ++b) {
      const double S = measurement.coil_covariance[kCoils * a + b];
      S_Ctr += S * Ctr[b];
      for (std::size_t k = 0; k < kParameters; ++k) S_CtJ[k] += S * CtJ[b][k];
    }
    result.chi2 -= Ctr[a] * S_Ctr;
    for (std::size_t k = 0; k < kParameters; ++k) {
      result.Jtr[k] -= CtJ[a][k] * S_Ctr;
      for (std::size_t j = 0; j < kParameters; ++j) result.JtJ[kParameters * k + j] -= CtJ[a][k] * S_CtJ[j];
    }
  }
}

}  // namespace

void Linearise(const Model& model, const Measurement& measurement, const PosePoint& pose,
               NormalEquations& result) noexcept {
  const Images images = MakeImages(model, pose);
  std::array<double, kParameters> rate{};
  for (std::size_t i = 0; i < 3; ++i) rate[i] = measurement.velocity_base_m_s[i];
  rate[3] = Dot(measurement.axis_rate_base_1_s, pose.tangent_1_base);
  rate[4] = Dot(measurement.axis_rate_base_1_s, pose.tangent_2_base);

  Sums sums;
  for (std::size_t first = 0; first < kSensors; first += kLaneWidth) {
    const LaneField field = FieldAt(model, images, pose, first);
    const Lane age = Load(measurement.age_s, first);
    for (std::size_t row = 0; row < 3; ++row) {
      const Lane3 w{Load(measurement.weight[3 * row], first), Load(measurement.weight[3 * row + 1], first),
                    Load(measurement.weight[3 * row + 2], first)};
      Lane r = Dot(w, field.B) - Load(measurement.whitened[row], first);
      std::array<Lane, kParameters> J;
      Lane drift{};
      for (std::size_t k = 0; k < kParameters; ++k) {
        J[k] = Dot(w, field.d[k]);
        drift += J[k] * rate[k];
      }
      r -= age * drift;
      Add(J, r, measurement, row, first, sums);
    }
  }
  Reduce(sums, result);
  EliminateCurrents(measurement, sums, result);
}

void EvaluateField(const Model& model, const PosePoint& pose, ModelField& result) noexcept {
  const Images images = MakeImages(model, pose);
  for (std::size_t first = 0; first < kSensors; first += kLaneWidth) {
    const LaneField field = FieldAt(model, images, pose, first);
    for (std::size_t row = 0; row < 3; ++row) {
      const Lane3 R{Load(model.gain_sensor_base[3 * row], first), Load(model.gain_sensor_base[3 * row + 1], first),
                    Load(model.gain_sensor_base[3 * row + 2], first)};
      const Lane B = Dot(R, field.B);
      for (std::size_t lane = 0; lane < kLaneWidth; ++lane) {
        const std::size_t reading = 3 * (first + lane) + row;
        result.field_sensor_T[reading] = B[lane];
        for (std::size_t k = 0; k < kParameters; ++k) result.jacobian[reading][k] = Dot(R, field.d[k])[lane];
      }
    }
  }
}

}  // namespace omni::tracker
