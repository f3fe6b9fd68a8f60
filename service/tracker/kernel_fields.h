// The field at a group of sensors and its derivatives by the pose. Internal to each kernel file, like kernel_lanes.h.
#pragma once

#include "service/tracker/kernel_lanes.h"

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

// Images of the tool's points in the core, and their derivatives by the parameters. One lane per point.
template <class Real>
struct alignas(64) ImageTable {
  Real position[3][kBlockSensors], moment[3][kBlockSensors], charge[kBlockSensors];
  Real position_d[kParameters][3][kBlockSensors], moment_d[kParameters][3][kBlockSensors];
  Real charge_d[kParameters][kBlockSensors];
  Real moment_position_d[kParameters][kBlockSensors];  // moment . position_d
  Real charge_sum, charge_d_sum[kParameters];          // over the points
};

// One point's image in lanes: a = core radius, n = P/|P|, m = moment u:
//   x' = (a/r)^2 P,  m' = kappa (a/r)^3 (2 (m.n) n - m),  q' = kappa a (m.n)/r^2     docs/theory/magnetics.md (10)
template <class Real>
struct PointImage {
  Lane3<Real> P, n, image_moment;
  Lane<Real> inv_r, un, mn, moment, ratio2, k, charge_scale;
};

// Stores the derivative along (dP, dm): by the product rule, with dr/r = n.dP/r, dn = dP/r - n dr/r.
template <class Real>
inline void StoreDerivative(const PointImage<Real>& at, const Real (&u)[3], const Lane3<Real>& dP,
                            const Lane3<Real>& dm, Lane<Real> dm_n, int parameter, int first,
                            ImageTable<Real>& images) {
  const Lane<Real> dr_r = Dot(at.n, dP) * at.inv_r;
  const Lane3<Real> dn{dP.x * at.inv_r - at.n.x * dr_r, dP.y * at.inv_r - at.n.y * dr_r,
                       dP.z * at.inv_r - at.n.z * dr_r};
  const Lane<Real> dmn = dm_n + at.moment * Dot(u, dn);
  const Lane<Real> two_dr = Real(2) * dr_r, three_dr = Real(3) * dr_r;
  const Lane<Real> a = Real(2) * dmn, b = Real(2) * at.mn;
  const Lane3<Real> dx{at.ratio2 * (dP.x - two_dr * at.P.x), at.ratio2 * (dP.y - two_dr * at.P.y),
                       at.ratio2 * (dP.z - two_dr * at.P.z)};
  const Lane3<Real>& m = at.image_moment;
  auto& position_d = images.position_d[parameter];
  auto& moment_d = images.moment_d[parameter];
  Store<Real>(dx.x, position_d[0] + first);
  Store<Real>(dx.y, position_d[1] + first);
  Store<Real>(dx.z, position_d[2] + first);
  Store<Real>(at.k * (a * at.n.x + b * dn.x - dm.x) - three_dr * m.x, moment_d[0] + first);
  Store<Real>(at.k * (a * at.n.y + b * dn.y - dm.y) - three_dr * m.y, moment_d[1] + first);
  Store<Real>(at.k * (a * at.n.z + b * dn.z - dm.z) - three_dr * m.z, moment_d[2] + first);
  Store<Real>(at.charge_scale * (dmn - two_dr * at.mn), images.charge_d[parameter] + first);
  Store<Real>(Dot(m, dx), images.moment_position_d[parameter] + first);
}

template <class Real, int kCount>
inline void MakeImages(const ToolSource<Real>& tool, const RealPose<Real>& pose, ImageTable<Real>& images) {
  if (tool.points == 0) return;
  const Real(&u)[3] = pose.u;
  for (int first = 0; first < tool.points; first += kLanes<Real>) {
    const Lane<Real> ring[2] = {Load<Real>(tool.ring_1_m + first), Load<Real>(tool.ring_2_m + first)};
    const Lane<Real> axial = Load<Real>(tool.axial_m + first);
    PointImage<Real> at;
    at.moment = Load<Real>(tool.moment_Am2 + first);
    const auto along = [&](int i) {
      return pose.p[i] + ring[0] * pose.e[0][i] + ring[1] * pose.e[1][i] + axial * u[i];
    };
    at.P = {along(0), along(1), along(2)};
    at.inv_r = Real(1) / Sqrt(Dot(at.P, at.P));
    at.n = {at.P.x * at.inv_r, at.P.y * at.inv_r, at.P.z * at.inv_r};
    at.un = Dot(u, at.n);
    at.mn = at.moment * at.un;
    const Lane<Real> ratio = tool.core_radius_m * at.inv_r;
    at.ratio2 = ratio * ratio;
    at.k = tool.core_kappa * ratio * at.ratio2;
    at.charge_scale = tool.core_kappa * ratio * at.inv_r;
    const Lane<Real> twice = Real(2) * at.mn;
    at.image_moment = {at.k * (twice * at.n.x - at.moment * u[0]), at.k * (twice * at.n.y - at.moment * u[1]),
                       at.k * (twice * at.n.z - at.moment * u[2])};
    Store<Real>(at.ratio2 * at.P.x, images.position[0] + first);
    Store<Real>(at.ratio2 * at.P.y, images.position[1] + first);
    Store<Real>(at.ratio2 * at.P.z, images.position[2] + first);
    Store<Real>(at.image_moment.x, images.moment[0] + first);
    Store<Real>(at.image_moment.y, images.moment[1] + first);
    Store<Real>(at.image_moment.z, images.moment[2] + first);
    Store<Real>(at.charge_scale * at.mn, images.charge + first);
    const Lane<Real> zero{};
    const Lane<Real> one = zero + Real(1);
    for (int k = 0; k < 3; ++k) {
      const Lane3<Real> dP{k == 0 ? one : zero, k == 1 ? one : zero, k == 2 ? one : zero};
      StoreDerivative<Real>(at, u, dP, {zero, zero, zero}, zero, k, first, images);
    }
    for (int k = 3; k < kCount; ++k) {  // turning u by e carries the ring along: de = -u, du = e
      const Real(&e)[3] = pose.e[k - 3];
      const Lane<Real>& r = ring[k - 3];
      const Lane3<Real> dP{axial * e[0] - r * u[0], axial * e[1] - r * u[1], axial * e[2] - r * u[2]};
      const Lane3<Real> dm{at.moment * e[0], at.moment * e[1], at.moment * e[2]};
      StoreDerivative<Real>(at, u, dP, dm, at.moment * Dot(e, at.n), k, first, images);
    }
  }
  images.charge_sum = 0;
  for (int i = 0; i < tool.points; ++i) images.charge_sum += images.charge[i];
  for (int k = 0; k < kCount; ++k) {
    images.charge_d_sum[k] = 0;
    for (int i = 0; i < tool.points; ++i) images.charge_d_sum[k] += images.charge_d[k][i];
  }
}

// Field in B at a group of sensors and its derivatives.
template <class Real, int kCount>
struct LaneField {
  Lane3<Real> B;
  Lane3<Real> d[kCount];
};

// The scalars of magnetics::ZonalSums for orders 1, 3, 5.
template <class Real>
struct Zonal {
  Lane<Real> p1, p2, beta, beta_d, curvature;
};

// P1 = c; P3 = (5 c^3 - 3 c)/2; P5 = (63 c^5 - 70 c^3 + 15 c)/8 and derivatives, written out.
template <class Real>
inline Zonal<Real> SumZonal(const ToolSource<Real>& tool, Lane<Real> c, Lane<Real> inv_r) {
  using R = Real;
  const Lane<R> ir2 = inv_r * inv_r;
  const Lane<R> A1 = kMu0Over4Pi<R> * tool.zonal[0] * (ir2 * inv_r);
  if (!tool.multipole) return {A1, Lane<R>{}, R(3) * c * A1, R(3) * A1, R(15) * c * A1};
  const Lane<R> c2 = c * c;
  const Lane<R> ir5 = ir2 * ir2 * inv_r;
  const Lane<R> A3 = kMu0Over4Pi<R> * tool.zonal[1] * ir5;
  const Lane<R> A5 = kMu0Over4Pi<R> * tool.zonal[2] * (ir5 * ir2);
  const Lane<R> P3 = R(0.5) * c * (R(5) * c2 - R(3)), P3d = R(0.5) * (R(15) * c2 - R(3)), P3dd = R(15) * c;
  const Lane<R> P5 = R(0.125) * c * ((R(63) * c2 - R(70)) * c2 + R(15)),
                P5d = R(0.125) * ((R(315) * c2 - R(210)) * c2 + R(15)), P5dd = R(0.5) * c * (R(315) * c2 - R(105));
  const Lane<R> beta1 = R(3) * c, beta3 = R(4) * P3 + c * P3d, beta5 = R(6) * P5 + c * P5d;
  const Lane<R> beta3d = R(5) * P3d + c * P3dd, beta5d = R(7) * P5d + c * P5dd;  // beta1' = 3
  return {A1 + A3 * P3d + A5 * P5d, A3 * P3dd + A5 * P5dd, A1 * beta1 + A3 * beta3 + A5 * beta5,
          R(3) * A1 + A3 * beta3d + A5 * beta5d,
          A1 * (R(5) * beta1) + A3 * (R(6) * beta3 + c * beta3d) + A5 * (R(8) * beta5 + c * beta5d)};
}

// Zonal field about u, seen from s: docs/theory/magnetics.md (4), (6), (7). Derivative by the tool's position is minus
// the gradient.
template <class Real, int kCount>
inline void SetTool(const ToolSource<Real>& tool, const RealPose<Real>& pose, const Lane3<Real>& s,
                    LaneField<Real, kCount>& out) {
  const Real(&u)[3] = pose.u;
  const Lane3<Real> d{s.x - pose.p[0], s.y - pose.p[1], s.z - pose.p[2]};
  const Lane<Real> inv_r = Real(1) / Sqrt(Dot(d, d));
  const Lane3<Real> n{d.x * inv_r, d.y * inv_r, d.z * inv_r};
  const Zonal<Real> sum = SumZonal<Real>(tool, Dot(u, n), inv_r);
  out.B = {sum.beta * n.x - sum.p1 * u[0], sum.beta * n.y - sum.p1 * u[1], sum.beta * n.z - sum.p1 * u[2]};
  const Lane<Real> p2 = sum.p2 * inv_r, beta_d = sum.beta_d * inv_r, curvature = sum.curvature * inv_r;
  const Lane<Real> n_of[3] = {n.x, n.y, n.z};
  for (int k = 0; k < 3; ++k) {
    const Lane<Real> along_u = p2 * u[k] - beta_d * n_of[k];
    const Lane<Real> along_n = curvature * n_of[k] - beta_d * u[k];
    out.d[k] = {along_u * u[0] + along_n * n.x, along_u * u[1] + along_n * n.y, along_u * u[2] + along_n * n.z};
  }
  const Lane<Real> beta = sum.beta * inv_r;
  out.d[0].x -= beta;
  out.d[1].y -= beta;
  out.d[2].z -= beta;
  for (int k = 3; k < kCount; ++k) {
    const Real(&e)[3] = pose.e[k - 3];
    const Lane<Real> ne = Dot(e, n);
    const Lane<Real> along_n = sum.beta_d * ne, along_u = sum.p2 * ne;
    out.d[k] = {along_n * n.x - along_u * u[0] - sum.p1 * e[0], along_n * n.y - along_u * u[1] - sum.p1 * e[1],
                along_n * n.z - along_u * u[2] - sum.p1 * e[2]};
  }
}

// Adds the images: dipole and charge at x', opposite charge at the origin. docs/theory/magnetics.md (11)
// Along a parameter (dx', dm', dq'), with e = -dx' the change of d = s - x':
//   dB = (3 (m.d)/r^5 + q/r^3) e + 3 (d.e)/r^5 m - dm/r^3 + dq (d/r^3 - s/|s|^3)
//        + [3 (m.e) + 3 (dm.d) - 3 q (d.e) - 15 (m.d)(d.e)/r^2] d/r^5                       (all times mu0/4pi)
template <class Real, int kCount>
inline void AddImages(const ToolSource<Real>& tool, const ImageTable<Real>& images, const Lane3<Real>& s,
                      const Lane3<Real>& centre, LaneField<Real, kCount>& out) {
  Lane3<Real> d[kBlockSensors];
  Lane<Real> ir3[kBlockSensors], ir5[kBlockSensors], along[kBlockSensors], charge[kBlockSensors];
  Lane3<Real> B = out.B;
  for (int i = 0; i < tool.points; ++i) {
    const Real m[3] = {images.moment[0][i], images.moment[1][i], images.moment[2][i]};
    const Real q = images.charge[i];
    d[i] = {s.x - images.position[0][i], s.y - images.position[1][i], s.z - images.position[2][i]};
    const Lane<Real> inv_r = Real(1) / Sqrt(Dot(d[i], d[i]));
    const Lane<Real> ir2 = inv_r * inv_r;
    ir3[i] = kMu0Over4Pi<Real> * (ir2 * inv_r);
    ir5[i] = Real(3) * (ir3[i] * ir2);
    const Lane<Real> md = Dot(m, d[i]);
    along[i] = ir5[i] * md + ir3[i] * q;
    charge[i] = q + Real(5) * md * ir2;
    B.x += along[i] * d[i].x - ir3[i] * m[0];
    B.y += along[i] * d[i].y - ir3[i] * m[1];
    B.z += along[i] * d[i].z - ir3[i] * m[2];
  }
  const Real q = kMu0Over4Pi<Real> * images.charge_sum;
  out.B = {B.x - q * centre.x, B.y - q * centre.y, B.z - q * centre.z};
  for (int k = 0; k < kCount; ++k) {
    Lane3<Real> sum = out.d[k];
    for (int i = 0; i < tool.points; ++i) {
      const Real m[3] = {images.moment[0][i], images.moment[1][i], images.moment[2][i]};
      const Real dx[3] = {images.position_d[k][0][i], images.position_d[k][1][i], images.position_d[k][2][i]};
      const Real dm[3] = {images.moment_d[k][0][i], images.moment_d[k][1][i], images.moment_d[k][2][i]};
      const Lane<Real> ed = Dot(dx, d[i]);  // -(d.e)
      const Lane<Real> on_d =
          ir5[i] * (Dot(dm, d[i]) - images.moment_position_d[k][i] + charge[i] * ed) + ir3[i] * images.charge_d[k][i];
      const Lane<Real> on_m = ir5[i] * ed;
      sum.x += on_d * d[i].x - on_m * m[0] - along[i] * dx[0] - ir3[i] * dm[0];
      sum.y += on_d * d[i].y - on_m * m[1] - along[i] * dx[1] - ir3[i] * dm[1];
      sum.z += on_d * d[i].z - on_m * m[2] - along[i] * dx[2] - ir3[i] * dm[2];
    }
    const Real dq = kMu0Over4Pi<Real> * images.charge_d_sum[k];
    out.d[k] = {sum.x - dq * centre.x, sum.y - dq * centre.y, sum.z - dq * centre.z};
  }
}

template <class Real, int kCount>
inline void FieldAt(const ToolSource<Real>& tool, const ImageTable<Real>& images, const RealPose<Real>& pose,
                    const Lane3<Real>& s, const Lane3<Real>& centre, LaneField<Real, kCount>& field) {
  SetTool<Real, kCount>(tool, pose, s, field);
  if (tool.points > 0) AddImages<Real, kCount>(tool, images, s, centre, field);
}

}  // namespace
}  // namespace omni::tracker
