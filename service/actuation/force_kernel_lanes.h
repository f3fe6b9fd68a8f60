// Body of the kernel, included once per instruction set with OMNI_LANE_BYTES and OMNI_FORCE_KERNEL defined.
// Lanes are points of the magnet. Formulas: docs/theory/actuation.md (2.1), (2.2), (2.4), (2.5); magnetics.md (4) -
// (6), (10).
#if !defined(OMNI_LANE_BYTES) || !defined(OMNI_FORCE_KERNEL)
#error "included by force_kernel_*.cc only"
#endif

#include "service/actuation/force_kernel.h"
#include "service/base/lanes.h"

namespace omni::actuation {
namespace {

constexpr int kLanes = base::kRegisterLanes<double>;
constexpr int kBlocks = kForcePoints / kLanes;
constexpr double kMu0Over4Pi = 1e-7;

using V = base::Lanes<double, kLanes>;

struct V3 {
  V x, y, z;
};

inline V Load(const double* from) noexcept {
  V v;
  base::LoadLanes(from, v);
  return v;
}

inline void Store(const V& v, double* to) noexcept { base::StoreLanes(v, to); }

inline V Sqrt(const V& v) noexcept {
  V roots;
  base::SqrtLanes<double, kLanes>(v, roots);
  return roots;
}

inline V Dot(const V3& a, const V3& b) noexcept { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline V Dot(const double* a, const V3& b) noexcept { return a[0] * b.x + a[1] * b.y + a[2] * b.z; }

// One block of points: where they are, and what all coils share about them.
struct Placed {
  V moment;
  V3 offset;  // from the magnet's centre
  V3 n;       // direction from the core
  V r2, inverse_r;
  V nu;  // n.u
};

// A force per point with its torque about the centre: G m u, and u x B + offset x G u.
struct Acting {
  V3 force;
  V3 field;
};

Placed Place(const ForceTables& tables, const ForcePose& pose, int first) noexcept {
  Placed at;
  const V a = Load(tables.ring_1_m + first), b = Load(tables.ring_2_m + first), c = Load(tables.axial_m + first);
  at.moment = Load(tables.moment_Am2 + first);
  at.offset = {a * pose.e1[0] + b * pose.e2[0] + c * pose.u[0], a * pose.e1[1] + b * pose.e2[1] + c * pose.u[1],
               a * pose.e1[2] + b * pose.e2[2] + c * pose.u[2]};
  const V3 p{at.offset.x + pose.position_m[0], at.offset.y + pose.position_m[1], at.offset.z + pose.position_m[2]};
  at.r2 = Dot(p, p);
  at.inverse_r = 1.0 / Sqrt(at.r2);
  at.n = {p.x * at.inverse_r, p.y * at.inverse_r, p.z * at.inverse_r};
  at.nu = Dot(pose.u, at.n);
  return at;
}

// Sums over the orders of one coil with t = A_l P_l etc.; the scalars of magnetics.md (5) follow from them:
//   beta = s0 + c s1,  beta' = (s1_l3 - s1) + c s2,  sum A ((l+3) beta + c beta') = s0_l3 + c s1_l3 + c beta'
struct OrderSums {
  V s0{}, s0_l3{};  // (l+1) P, (l+1)(l+3) P
  V s1{}, s1_l3{};  // P', (l+3) P'
  V s2{};           // P''
};

inline OrderSums SumOrders(const double* q, const V& c, const V& inverse_r) noexcept {
  OrderSums sums;
  const V inverse_r2 = inverse_r * inverse_r;
  V scale = kMu0Over4Pi * inverse_r2 * inverse_r;
  V P_below = V{} + 1.0, P1_below{}, P2_below{};
  V P = c, P1 = P_below, P2{};
#pragma GCC unroll 8
  for (int j = 0; j < kForceOrders; ++j) {
    const double l = 2.0 * j + 1;
    const V A = scale * q[j];
    const V t0 = A * P, t1 = A * P1;
    sums.s0 += (l + 1) * t0;
    sums.s0_l3 += ((l + 1) * (l + 3)) * t0;
    sums.s1 += t1;
    sums.s1_l3 += (l + 3) * t1;
    sums.s2 += A * P2;
    scale *= inverse_r2;
    // P_(l+1) = ((2l+1) c P_l - l P_(l-1)) / (l+1) and its derivatives, twice [Abramowitz & Stegun 8.5.3, 8.5.4]
    const V P_even = ((2 * l + 1) / (l + 1)) * c * P - (l / (l + 1)) * P_below;
    const V P1_even = P1_below + (2 * l + 1) * P;
    const V P2_even = P2_below + (2 * l + 1) * P1;
    const V P_odd = ((2 * l + 3) / (l + 2)) * c * P_even - ((l + 1) / (l + 2)) * P;
    const V P1_odd = P1 + (2 * l + 3) * P_even;
    const V P2_odd = P2 + (2 * l + 3) * P1_even;
    P_below = P_even, P1_below = P1_even, P2_below = P2_even;
    P = P_odd, P1 = P1_odd, P2 = P2_odd;
  }
  return sums;
}

// Field of coil k per ampere and its derivative along u, times the moments.
inline Acting OfCoil(const double* q, const double* a, const double* u, const Placed& at) noexcept {
  const V c = Dot(a, at.n);
  const OrderSums s = SumOrders(q, c, at.inverse_r);
  const V beta = s.s0 + c * s.s1;
  const V beta_d = (s.s1_l3 - s.s1) + c * s.s2;
  const V curvature = s.s0_l3 + c * s.s1_l3 + c * beta_d;
  const double au = a[0] * u[0] + a[1] * u[1] + a[2] * u[2];
  const V along_a = s.s2 * au - beta_d * at.nu;
  const V along_n = curvature * at.nu - beta_d * au;
  const V gain = -at.moment * at.inverse_r;
  return {.force = {gain * (along_a * a[0] + along_n * at.n.x - beta * u[0]),
                    gain * (along_a * a[1] + along_n * at.n.y - beta * u[1]),
                    gain * (along_a * a[2] + along_n * at.n.z - beta * u[2])},
          .field = {at.moment * (beta * at.n.x - s.s1 * a[0]), at.moment * (beta * at.n.y - s.s1 * a[1]),
                    at.moment * (beta * at.n.z - s.s1 * a[2])}};
}

// The core's response to every point: image dipole and charge; all opposite charges lie at the core's centre.
struct Images {
  double x[kForcePoints], y[kForcePoints], z[kForcePoints];
  double mx[kForcePoints], my[kForcePoints], mz[kForcePoints];
  double charge[kForcePoints];
  double charge_sum;
};

inline void PlaceImages(const ForceTables& tables, const double* u, const Placed& at, int first,
                        Images& images) noexcept {
  const V ratio = tables.core_radius_m * at.inverse_r;
  const V strength = tables.core_kappa * ratio * ratio * ratio * at.moment;
  const V twice = 2.0 * at.nu;
  const V out = ratio * ratio * (at.r2 * at.inverse_r);
  Store(out * at.n.x, images.x + first);
  Store(out * at.n.y, images.y + first);
  Store(out * at.n.z, images.z + first);
  Store(strength * (twice * at.n.x - u[0]), images.mx + first);
  Store(strength * (twice * at.n.y - u[1]), images.my + first);
  Store(strength * (twice * at.n.z - u[2]), images.mz + first);
  Store(tables.core_kappa * ratio * at.inverse_r * at.moment * at.nu, images.charge + first);
}

// One image on one block of points, per moment: adds B and G u.
//   dipole: B = 3 (m.e) e - m, G u = 3 [(m.u) e + (m.e) u + (e.u) m - 5 (m.e)(e.u) e], over d^3 and d^4
//   charge: B = e, G u = u - 3 (e.u) e, over d^2 and d^3
inline void AddImage(const Images& images, int s, const double* u, const V3& p, Acting& sum) noexcept {
  const V3 d{p.x - images.x[s], p.y - images.y[s], p.z - images.z[s]};
  const double m[3] = {images.mx[s], images.my[s], images.mz[s]};
  const double mu = m[0] * u[0] + m[1] * u[1] + m[2] * u[2];
  const V inverse = 1.0 / Sqrt(Dot(d, d));
  const V3 e{d.x * inverse, d.y * inverse, d.z * inverse};
  const V k3 = kMu0Over4Pi * inverse * inverse * inverse;
  const V k4 = 3.0 * k3 * inverse;
  const V qk3 = images.charge[s] * k3;
  const V me = Dot(m, e), eu = Dot(u, e);
  const V along_e = k4 * (mu - 5.0 * me * eu) - 3.0 * qk3 * eu;
  const V along_u = k4 * me + qk3;
  const V along_m = k4 * eu;
  sum.force.x += along_e * e.x + along_u * u[0] + along_m * m[0];
  sum.force.y += along_e * e.y + along_u * u[1] + along_m * m[1];
  sum.force.z += along_e * e.z + along_u * u[2] + along_m * m[2];
  const V field_e = 3.0 * k3 * me + images.charge[s] * kMu0Over4Pi * inverse * inverse;
  sum.field.x += field_e * e.x - k3 * m[0];
  sum.field.y += field_e * e.y - k3 * m[1];
  sum.field.z += field_e * e.z - k3 * m[2];
}

inline Acting OfImages(const Images& images, const double* u, const Placed& at) noexcept {
  const V r = at.r2 * at.inverse_r;
  const V3 p{r * at.n.x, r * at.n.y, r * at.n.z};
  Acting sum{};
  for (int s = 0; s < kForcePoints; ++s) AddImage(images, s, u, p, sum);
  const V centre = images.charge_sum * kMu0Over4Pi * at.inverse_r * at.inverse_r;
  const V slope = centre * at.inverse_r;
  const V along_n = 3.0 * slope * at.nu;
  return {.force = {at.moment * (sum.force.x + along_n * at.n.x - slope * u[0]),
                    at.moment * (sum.force.y + along_n * at.n.y - slope * u[1]),
                    at.moment * (sum.force.z + along_n * at.n.z - slope * u[2])},
          .field = {at.moment * (sum.field.x - centre * at.n.x), at.moment * (sum.field.y - centre * at.n.y),
                    at.moment * (sum.field.z - centre * at.n.z)}};
}

// Values per point, added up in one order whatever the lanes.
struct Gathered {
  double value[6][kForcePoints];  // force, torque

  void Put(const Acting& acting, const double* u, const Placed& at, int first) noexcept {
    const V3& f = acting.force;
    const V3& B = acting.field;
    const V3& o = at.offset;
    Store(f.x, value[0] + first);
    Store(f.y, value[1] + first);
    Store(f.z, value[2] + first);
    Store(u[1] * B.z - u[2] * B.y + o.y * f.z - o.z * f.y, value[3] + first);
    Store(u[2] * B.x - u[0] * B.z + o.z * f.x - o.x * f.z, value[4] + first);
    Store(u[0] * B.y - u[1] * B.x + o.x * f.y - o.y * f.x, value[5] + first);
  }
  void Sum(double* force, double* torque) const noexcept {
    for (int i = 0; i < 3; ++i) {
      force[i] = Total(value[i]);
      torque[i] = Total(value[3 + i]);
    }
  }
  static double Total(const double* v) noexcept {
    return ((v[0] + v[1]) + (v[2] + v[3])) + ((v[4] + v[5]) + (v[6] + v[7]));
  }
};

}  // namespace

void OMNI_FORCE_KERNEL(const ForceTables& tables, const ForcePose& pose, ForceSums& sums) noexcept {
  Placed blocks[kBlocks];
  Images images;
  for (int i = 0; i < kBlocks; ++i) {
    blocks[i] = Place(tables, pose, i * kLanes);
    Store(blocks[i].r2, sums.square_radius_m2 + i * kLanes);
    PlaceImages(tables, pose.u, blocks[i], i * kLanes, images);
  }
  images.charge_sum = Gathered::Total(images.charge);
  Gathered gathered;
  for (int k = 0; k < kForceCoils; ++k) {
    for (int i = 0; i < kBlocks; ++i) {
      gathered.Put(OfCoil(tables.zonal[k], tables.axis_base[k], pose.u, blocks[i]), pose.u, blocks[i], i * kLanes);
    }
    gathered.Sum(sums.force_N_A[k], sums.torque_Nm_A[k]);
  }
  for (int i = 0; i < kBlocks; ++i) {
    gathered.Put(OfImages(images, pose.u, blocks[i]), pose.u, blocks[i], i * kLanes);
  }
  gathered.Sum(sums.snapping_N, sums.snapping_Nm);
}

}  // namespace omni::actuation
