#include "service/sim/fields/winding.h"
#include "service/sim/fields/vec3.h"

#include <cmath>
#include <numbers>

namespace omni::sim {
namespace {

constexpr double kReference_m = 0.04;  // of the series' scaling, near the radii of interest
constexpr double kAxisBand = 1e-4;     // of the turn's radius: nearer to the axis B_rho is its linear term

// C^{3/2}_n(c), n = 0..kOrder: Gegenbauer polynomials, here P'_{n+1}(c).
std::array<double, ZonalSeries::kOrder + 1> Gegenbauer(double c) noexcept {
  std::array<double, ZonalSeries::kOrder + 1> g{};
  g[0] = 1;
  g[1] = 3 * c;
  for (std::size_t n = 2; n < g.size(); ++n) {
    const double order = static_cast<double>(n);
    g[n] = ((2 * order + 1) * c * g[n - 1] - (order + 1) * g[n - 2]) / order;
  }
  return g;
}

// How much of the answer of an infinitely permeable sphere a finite one gives at order l: l (mu-1) / (l mu + l + 1)
// written with kappa = (mu-1) / (mu+2).
double CoreFactor(int l, double kappa) noexcept { return 3 * l * kappa / (2 * l + 1 + kappa * (l - 1)); }

ZonalFields ZonalKernel() noexcept {
  static const ZonalFields fields = FastestZonalFields();
  return fields;
}

}  // namespace

Elliptic EllipticIntegrals(double m) noexcept {
  double a = 1;
  double b = std::sqrt(1 - m);
  double sum = 0.5 * m;
  double power = 0.5;
  for (int i = 0; i < 20 && a - b > 1e-16 * a; ++i) {
    const double c = 0.5 * (a - b);
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
    power *= 2;
    sum += power * c * c;
  }
  const double k = std::numbers::pi / (2 * a);
  return {k, k * (1 - sum)};
}

// [Smythe, Static and Dynamic Electricity 3e, 7.10]
CylinderField TurnField(double radius_m, double rho_m, double z_m) noexcept {
  const double a = radius_m;
  const double outer = (a + rho_m) * (a + rho_m) + z_m * z_m;
  const double inner = (a - rho_m) * (a - rho_m) + z_m * z_m;
  const Elliptic integral = EllipticIntegrals(4 * a * rho_m / outer);
  const double scale = kMu0 / (2 * std::numbers::pi * std::sqrt(outer));
  CylinderField field;
  field.z_T = scale * (integral.k + (a * a - rho_m * rho_m - z_m * z_m) / inner * integral.e);
  if (rho_m < kAxisBand * a) {
    const double r2 = a * a + z_m * z_m;
    field.rho_T = 0.75 * kMu0 * a * a * z_m * rho_m / (r2 * r2 * std::sqrt(r2));
  } else {
    field.rho_T = scale * z_m / rho_m * (-integral.k + (a * a + rho_m * rho_m + z_m * z_m) / inner * integral.e);
  }
  return field;
}

std::vector<Turn> WindTurns(const base::CoilGeometry& coil, int index) {
  std::vector<Turn> turns;
  const double pitch_m = (coil.shell_radius_max_m - coil.shell_radius_min_m) / (base::kCoilCount * coil.layers);
  for (int layer = 0; layer < coil.layers; ++layer) {
    const double shell_m = coil.shell_radius_min_m + pitch_m * (base::kCoilCount * layer + index + 0.5);
    const int count = coil.turns / coil.layers + (layer >= coil.layers - coil.turns % coil.layers ? 1 : 0);
    for (int i = 0; i < count; ++i) {
      const double height_m = coil.band_half_width_m * (2 * (i + 0.5) / count - 1);
      turns.push_back({std::sqrt(shell_m * shell_m - height_m * height_m), height_m});
    }
  }
  return turns;
}

// A turn at distance R from the centre, polar angle th, radius s = R sin th:
//   inside,  on the axis: B = sum b_l z^(l-1),  b_l = mu0 s^2 / (2 R^3) C^{3/2}_{l-1}(cos th) / R^(l-1)
//   outside: q_l = mu0 s^2 / 2 C^{3/2}_{l-1}(cos th) R^(l-1) / (1e-7 (l+1))
// The core answers b_l with q_l = 4 pi b_l a^(2l+1) / (mu0 l).
ZonalSeries::Parts ZonalSeries::Expand(const std::vector<Turn>& turns, double core_radius_m,
                                       double core_kappa) noexcept {
  Parts parts;
  for (const Turn& turn : turns) {
    const double r = std::hypot(turn.radius_m, turn.height_m);
    const auto g = Gegenbauer(turn.height_m / r);
    const double half = 0.5 * kMu0 * turn.radius_m * turn.radius_m;
    for (int l = 1; l <= kOrder; l += 2) {
      const auto at = static_cast<std::size_t>(l);
      const double b_l = half / std::pow(r, l + 2) * g[at - 1];
      parts.turns[at] += half * g[at - 1] * std::pow(r, l - 1) / (1e-7 * (l + 1));
      parts.core[at] += CoreFactor(l, core_kappa) * 1e7 * b_l * std::pow(core_radius_m, 2 * l + 1) / l;
    }
  }
  return parts;
}

ZonalSeries::ZonalSeries(const std::array<double, kOrder + 1>& q, const Vec3& axis_base) noexcept : moment_(q[1]) {
  terms_.axis = {axis_base.x, axis_base.y, axis_base.z};
  terms_.reference_m = kReference_m;
  for (std::size_t l = 1; l < q.size(); ++l) {
    terms_.scaled[l] = 1e-7 * q[l] / std::pow(kReference_m, static_cast<double>(l) + 2);
  }
}

std::array<Vec3, kChargeLanes> ZonalSeries::Fields(const std::array<Vec3, kChargeLanes>& points_base_m) const noexcept {
  std::array<std::array<double, kChargeLanes>, 3> at;
  for (std::size_t lane = 0; lane < kChargeLanes; ++lane) {
    at[0][lane] = points_base_m[lane].x;
    at[1][lane] = points_base_m[lane].y;
    at[2][lane] = points_base_m[lane].z;
  }
  std::array<std::array<double, kChargeLanes>, 3> b;
  ZonalKernel()(terms_, at[0].data(), at[1].data(), at[2].data(), kChargeLanes, b[0].data(), b[1].data(), b[2].data());
  std::array<Vec3, kChargeLanes> fields_T;
  for (std::size_t lane = 0; lane < kChargeLanes; ++lane) fields_T[lane] = {b[0][lane], b[1][lane], b[2][lane]};
  return fields_T;
}

Vec3 ZonalSeries::Field(const Vec3& point_base_m) const noexcept {
  std::array<Vec3, kChargeLanes> points_base_m;
  points_base_m.fill(point_base_m);
  return Fields(points_base_m)[0];
}

void ZonalSeries::FieldsAt(const Charges& charges, FieldArray& fields_T) const noexcept {
  ZonalKernel()(terms_, charges.x.data(), charges.y.data(), charges.z.data(), charges.x.size(), fields_T.x.data(),
                fields_T.y.data(), fields_T.z.data());
}

CoilTruth::CoilTruth(const base::CoilGeometry& coil, int index, const Vec3& axis_base, double strength,
                     double core_radius_m, double core_kappa, const Vec3& core_centre_base_m)
    : turns_(WindTurns(coil, index)),
      axis_(axis_base),
      strength_(strength),
      core_centre_base_m_(core_centre_base_m),
      core_is_centred_(core_centre_base_m == Vec3{}) {
  ZonalSeries::Parts parts = ZonalSeries::Expand(turns_, core_radius_m, core_kappa);
  for (std::size_t l = 0; l < parts.turns.size(); ++l) {
    parts.core[l] *= strength;
    parts.turns[l] = parts.turns[l] * strength + parts.core[l];
  }
  core_ = ZonalSeries(parts.core, axis_base);
  total_ = ZonalSeries(parts.turns, axis_base);
  if (core_is_centred_) return;
  for (std::size_t l = 0; l < parts.turns.size(); ++l) parts.turns[l] -= parts.core[l];
  turns_series_ = ZonalSeries(parts.turns, axis_base);
  constexpr double kStep_m = 1e-4;
  const double scale = CoreFactor(2, core_kappa) * std::pow(core_radius_m, 5) / (2 * kStep_m);
  for (std::size_t j = 0; j < 3; ++j) {
    const Vec3 step = kStep_m * kUnits[j];
    order_2_T_m4_[j] = scale * (FieldOfTurns(core_centre_base_m_ + step) - FieldOfTurns(core_centre_base_m_ - step));
  }
}

void CoilTruth::FieldsBySeries(const Charges& charges, FieldArray& fields_T) const noexcept {
  if (core_is_centred_) return total_.FieldsAt(charges, fields_T);
  turns_series_.FieldsAt(charges, fields_T);
  std::array<Vec3, kChargeLanes> from_core;
  for (std::size_t i = 0; i < charges.x.size(); i += kChargeLanes) {
    for (std::size_t lane = 0; lane < kChargeLanes; ++lane) {
      from_core[lane] = charges.position(i + lane) - core_centre_base_m_;
    }
    const std::array<Vec3, kChargeLanes> core_T = core_.Fields(from_core);
    for (std::size_t lane = 0; lane < kChargeLanes; ++lane) {
      const Vec3 field_T = core_T[lane] + Order2(from_core[lane]);
      fields_T.x[i + lane] += field_T.x;
      fields_T.y[i + lane] += field_T.y;
      fields_T.z[i + lane] += field_T.z;
    }
  }
}

Vec3 CoilTruth::FieldOfTurns(const Vec3& point_base_m) const noexcept {
  const double z = Dot(point_base_m, axis_);
  const Vec3 across = point_base_m - z * axis_;
  const double rho = Norm(across);
  CylinderField sum;
  for (const Turn& turn : turns_) {
    const CylinderField field = TurnField(turn.radius_m, rho, z - turn.height_m);
    sum.rho_T += field.rho_T;
    sum.z_T += field.z_T;
  }
  Vec3 b = (strength_ * sum.z_T) * axis_;
  if (rho > 0) b += (strength_ * sum.rho_T / rho) * across;
  return b;
}

// Of a linear field G x: -kappa_2 a^5 (G x / r^5 - 5/2 (x.G x) x / r^7).
Vec3 CoilTruth::Order2(const Vec3& x) const noexcept {
  const double r2 = Dot(x, x);
  const double inverse_r5 = 1 / (r2 * r2 * std::sqrt(r2));
  const Vec3 gx = x.x * order_2_T_m4_[0] + x.y * order_2_T_m4_[1] + x.z * order_2_T_m4_[2];
  return inverse_r5 * ((2.5 * Dot(x, gx) / r2) * x - gx);
}

Vec3 CoilTruth::CoreField(const Vec3& point_base_m) const noexcept {
  const Vec3 x = point_base_m - core_centre_base_m_;
  return core_is_centred_ ? core_.Field(x) : core_.Field(x) + Order2(x);
}

Vec3 CoilTruth::FieldByTurns(const Vec3& point_base_m) const noexcept {
  return FieldOfTurns(point_base_m) + CoreField(point_base_m);
}

}  // namespace omni::sim
