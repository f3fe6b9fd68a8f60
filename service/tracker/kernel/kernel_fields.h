// The field at a group of sensors and its derivatives by the pose. Internal to each kernel file, like kernel_lanes.h.
#pragma once

#include "service/tracker/kernel/kernel_lanes.h"

namespace omni::tracker {
namespace {

template <class Real>
constexpr Real kMu0Over4Pi = static_cast<Real>(1e-7);

template <class Real>
struct RealPose {
  Real p[3], u[3], e[2][3], rate[kParameters];
};

template <class Real>
inline RealPose<Real> Narrow(const KernelPose& pose) {
  RealPose<Real> at;
  for (int i = 0; i < 3; ++i) {
    at.p[i] = static_cast<Real>(pose.position_base_m[i]);
    at.u[i] = static_cast<Real>(pose.axis_base[i]);
    at.e[0][i] = static_cast<Real>(pose.tangent_1_base[i]);
    at.e[1][i] = static_cast<Real>(pose.tangent_2_base[i]);
  }
  for (int k = 0; k < kParameters; ++k) at.rate[k] = static_cast<Real>(pose.rate_1_s[k]);
  return at;
}

// Field in B and its derivatives by the parameters.
template <class Real, int kCount>
struct LaneField {
  Lane3<Real> B;
  Lane3<Real> d[kCount];
};

// Scalar potential, B = -grad, and its derivatives by the parameters.
template <class Real, int kCount>
struct LanePotential {
  Lane<Real> value;
  Lane<Real> d[kCount];
};

// The scalars of magnetics::ZonalSums for orders 1, 3, 5, with A_l = mu0/4pi q_l / r^(l+2): p0 = sum A_l P_l,
// p1 = sum A_l P_l', p2 = sum A_l P_l'', beta = sum A_l ((l+1) P_l + c P_l'), curvature = sum A_l of the second order.
template <class Real>
struct Zonal {
  Lane<Real> p0, p1, p2, beta, beta_d, curvature;
};

// P1 = c; P3 = (5 c^3 - 3 c)/2; P5 = (63 c^5 - 70 c^3 + 15 c)/8 and derivatives, written out.
template <class Real>
inline Zonal<Real> SumZonal(const ToolSource<Real>& tool, Lane<Real> c, Lane<Real> inv_r) {
  using R = Real;
  const Lane<R> ir2 = inv_r * inv_r;
  const Lane<R> A1 = kMu0Over4Pi<R> * tool.zonal[0] * (ir2 * inv_r);
  if (!tool.multipole) return {c * A1, A1, Lane<R>{}, R(3) * c * A1, R(3) * A1, R(15) * c * A1};
  const Lane<R> c2 = c * c;
  const Lane<R> ir5 = ir2 * ir2 * inv_r;
  const Lane<R> A3 = kMu0Over4Pi<R> * tool.zonal[1] * ir5;
  const Lane<R> A5 = kMu0Over4Pi<R> * tool.zonal[2] * (ir5 * ir2);
  const Lane<R> P3 = R(0.5) * c * (R(5) * c2 - R(3)), P3d = R(0.5) * (R(15) * c2 - R(3)), P3dd = R(15) * c;
  const Lane<R> P5 = R(0.125) * c * ((R(63) * c2 - R(70)) * c2 + R(15)),
                P5d = R(0.125) * ((R(315) * c2 - R(210)) * c2 + R(15)), P5dd = R(0.5) * c * (R(315) * c2 - R(105));
  const Lane<R> beta1 = R(3) * c, beta3 = R(4) * P3 + c * P3d, beta5 = R(6) * P5 + c * P5d;
  const Lane<R> beta3d = R(5) * P3d + c * P3dd, beta5d = R(7) * P5d + c * P5dd;  // beta1' = 3
  return {A1 * c + A3 * P3 + A5 * P5,
          A1 + A3 * P3d + A5 * P5d,
          A3 * P3dd + A5 * P5dd,
          A1 * beta1 + A3 * beta3 + A5 * beta5,
          R(3) * A1 + A3 * beta3d + A5 * beta5d,
          A1 * (R(5) * beta1) + A3 * (R(6) * beta3 + c * beta3d) + A5 * (R(8) * beta5 + c * beta5d)};
}

// The tool seen from a place s, d = s - p = r n, c = u.n.
template <class Real>
struct Sight {
  Lane3<Real> d, n;
  Lane<Real> r, inv_r;
  Zonal<Real> sum;
};

template <class Real>
inline Sight<Real> Look(const ToolSource<Real>& tool, const RealPose<Real>& pose, const Lane3<Real>& s) {
  Sight<Real> at;
  at.d = {s.x - pose.p[0], s.y - pose.p[1], s.z - pose.p[2]};
  at.r = Sqrt(Dot(at.d, at.d));
  at.inv_r = Real(1) / at.r;
  at.n = {at.d.x * at.inv_r, at.d.y * at.inv_r, at.d.z * at.inv_r};
  at.sum = SumZonal<Real>(tool, Dot(pose.u, at.n), at.inv_r);
  return at;
}

template <class Real>
inline Lane3<Real> FieldOf(const Sight<Real>& at, const Real (&u)[3]) {
  const Zonal<Real>& sum = at.sum;
  return {sum.beta * at.n.x - sum.p1 * u[0], sum.beta * at.n.y - sum.p1 * u[1], sum.beta * at.n.z - sum.p1 * u[2]};
}

// Zonal field about u: docs/theory/magnetics.md (4), (6), (7). The derivative by the tool's position is minus the
// gradient, a symmetric matrix without a trace.
template <class Real, int kCount>
inline LaneField<Real, kCount> ToolField(const Sight<Real>& at, const RealPose<Real>& pose) {
  const Real(&u)[3] = pose.u;
  const Zonal<Real>& sum = at.sum;
  const Lane3<Real>& n = at.n;
  LaneField<Real, kCount> out;
  out.B = FieldOf(at, u);
  const Lane<Real> p2 = sum.p2 * at.inv_r, beta_d = sum.beta_d * at.inv_r, curvature = sum.curvature * at.inv_r;
  const Lane<Real> beta = sum.beta * at.inv_r;
  const Lane<Real> u_x = p2 * u[0] - beta_d * n.x, n_x = curvature * n.x - beta_d * u[0];
  const Lane<Real> u_y = p2 * u[1] - beta_d * n.y, n_y = curvature * n.y - beta_d * u[1];
  const Lane<Real> xx = u_x * u[0] + n_x * n.x - beta, yy = u_y * u[1] + n_y * n.y - beta;
  const Lane<Real> xy = u_x * u[1] + n_x * n.y, xz = u_x * u[2] + n_x * n.z, yz = u_y * u[2] + n_y * n.z;
  out.d[0] = {xx, xy, xz};
  out.d[1] = {xy, yy, yz};
  out.d[2] = {xz, yz, -(xx + yy)};
  for (int k = 3; k < kCount; ++k) {
    const Real(&e)[3] = pose.e[k - 3];
    const Lane<Real> ne = Dot(e, n);
    const Lane<Real> along_n = sum.beta_d * ne, along_u = sum.p2 * ne;
    out.d[k] = {along_n * n.x - along_u * u[0] - sum.p1 * e[0], along_n * n.y - along_u * u[1] - sum.p1 * e[1],
                along_n * n.z - along_u * u[2] - sum.p1 * e[2]};
  }
  return out;
}

template <class Real>
inline Lane<Real> PotentialOf(const Sight<Real>& at) {
  return at.r * at.sum.p0;
}

// phi = r sum A_l P_l; by the tool's position it grows with B, by a turn of u along e with p1 (e.d).
template <class Real, int kCount>
inline LanePotential<Real, kCount> ToolPotential(const Sight<Real>& at, const Lane3<Real>& B,
                                                 const RealPose<Real>& pose) {
  LanePotential<Real, kCount> out;
  out.value = PotentialOf(at);
  out.d[0] = B.x;
  out.d[1] = B.y;
  out.d[2] = B.z;
  for (int k = 3; k < kCount; ++k) out.d[k] = at.sum.p1 * Dot(pose.e[k - 3], at.d);
  return out;
}

template <class Real>
inline Sight<Real> LookFromCentre(const ToolSource<Real>& tool, const RealPose<Real>& pose) {
  return Look<Real>(tool, pose, {Lane<Real>{}, Lane<Real>{}, Lane<Real>{}});
}

// The potential at the core's centre, the same in every lane: the core stays neutral.
template <class Real, int kCount>
inline LanePotential<Real, kCount> CentrePotential(const ToolSource<Real>& tool, const RealPose<Real>& pose) {
  const Sight<Real> at = LookFromCentre(tool, pose);
  return ToolPotential<Real, kCount>(at, FieldOf(at, pose.u), pose);
}

// What the core adds at a sensor s, from the tool's field and potential at the sensor's own image s' = (a/|s|)^2 s
// (Kelvin inversion, docs/theory/tracking.md (2.1)):
//   kappa (a/|s|)^3 (2 (n.B') n - B') - kappa a/|s|^2 (phi' - phi_0) n,   n = s/|s|
template <class Real>
inline void AddReflected(const Lane3<Real>& n, Lane<Real> field_gain, Lane<Real> potential_gain, const Lane3<Real>& B,
                         Lane<Real> potential, Lane3<Real>& out) {
  const Lane<Real> along = Real(2) * field_gain * Dot(n, B) - potential_gain * potential;
  out.x += along * n.x - field_gain * B.x;
  out.y += along * n.y - field_gain * B.y;
  out.z += along * n.z - field_gain * B.z;
}

template <class Real, int kCount>
inline LaneField<Real, kCount> FieldAt(const ToolSource<Real>& tool, const RealPose<Real>& pose,
                                       const LanePotential<Real, kCount>& centre, const SensorPlaces<Real>& places,
                                       int first) {
  LaneField<Real, kCount> field =
      ToolField<Real, kCount>(Look(tool, pose, Load3<Real>(places.position_base_m, first)), pose);
  if (!tool.core) return field;
  const Sight<Real> image = Look(tool, pose, Load3<Real>(places.image_base_m, first));
  const LaneField<Real, kCount> B = ToolField<Real, kCount>(image, pose);
  const LanePotential<Real, kCount> phi = ToolPotential<Real, kCount>(image, B.B, pose);
  const Lane3<Real> n = Load3<Real>(places.radial_base, first);
  const Lane<Real> field_gain = Load<Real>(places.image_field_gain + first);
  const Lane<Real> potential_gain = Load<Real>(places.image_potential_gain_1_m + first);
  AddReflected<Real>(n, field_gain, potential_gain, B.B, phi.value - centre.value, field.B);
  for (int k = 0; k < kCount; ++k) {
    AddReflected<Real>(n, field_gain, potential_gain, B.d[k], phi.d[k] - centre.d[k], field.d[k]);
  }
  return field;
}

// The field alone.
template <class Real>
inline Lane3<Real> FieldOnlyAt(const ToolSource<Real>& tool, const RealPose<Real>& pose, Lane<Real> centre_potential,
                               const SensorPlaces<Real>& places, int first) {
  Lane3<Real> B = FieldOf(Look(tool, pose, Load3<Real>(places.position_base_m, first)), pose.u);
  if (!tool.core) return B;
  const Sight<Real> image = Look(tool, pose, Load3<Real>(places.image_base_m, first));
  AddReflected<Real>(Load3<Real>(places.radial_base, first), Load<Real>(places.image_field_gain + first),
                     Load<Real>(places.image_potential_gain_1_m + first), FieldOf(image, pose.u),
                     PotentialOf(image) - centre_potential, B);
  return B;
}

}  // namespace
}  // namespace omni::tracker
