// The truth about a coil: every turn a circular loop, and the iron core's answer as a zonal series.
#pragma once

#include <array>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/sim/fields/charge_kernel.h"
#include "service/sim/fields/charges.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {

struct Turn {
  double radius_m = 0;
  double height_m = 0;  // of its plane above the coil's centre, along the axis
};

// Complete elliptic integrals by the arithmetic-geometric mean [Abramowitz, Stegun 17.6]; m = k^2 in [0, 1).
struct Elliptic {
  double k = 0;
  double e = 0;
};
Elliptic EllipticIntegrals(double m) noexcept;

// Field of one turn at 1 A in cylinder coordinates about its axis; z is measured from the turn's own plane.
struct CylinderField {
  double rho_T = 0;
  double z_T = 0;
};
CylinderField TurnField(double radius_m, double rho_m, double z_m) noexcept;

// Turns of coil `index`: 3 x layers spherical shells of equal pitch between the radii, dealt out x, y, z, x, ...; in a
// shell the turns are equally spaced over |height| <= band half width. Turns that do not divide go to the outer layers.
std::vector<Turn> WindTurns(const base::CoilGeometry& coil, int index);

// Exterior zonal harmonics about one axis, at 1 A. Only odd orders: the windings are symmetric about their equator.
// Outside the largest turn, B = sum_l 1e-7 q_l / r^(l+2) [(l+1) P_l(c) r^ - P_l'(c) (u - c r^)], c = u . r^.
class ZonalSeries {
 public:
  static constexpr int kOrder = kZonalOrder;

  // q_l of the turns [magnetics: exterior expansion of a loop] and of the core that they magnetise.
  struct Parts {
    std::array<double, kOrder + 1> turns{};
    std::array<double, kOrder + 1> core{};
  };
  static Parts Expand(const std::vector<Turn>& turns, double core_radius_m, double core_kappa) noexcept;

  ZonalSeries() = default;
  ZonalSeries(const std::array<double, kOrder + 1>& q, const Vec3& axis_base) noexcept;

  Vec3 Field(const Vec3& point_base_m) const noexcept;
  // The same at each of these, in the time of one.
  std::array<Vec3, kChargeLanes> Fields(const std::array<Vec3, kChargeLanes>& points_base_m) const noexcept;
  // The same where each charge lies, in a quarter of the time. `fields_T` is of the charges' size.
  void FieldsAt(const Charges& charges, FieldArray& fields_T) const noexcept;
  double moment_Am2() const noexcept { return moment_; }

 private:
  ZonalTerms terms_;
  double moment_ = 0;
};

// One coil as it really is: axis and strength may be off nominal, and the core off its centre. To first order in the
// offset the core's answer is then shifted, and the winding's field, which has no gradient in its own centre, has one
// at the core's, which order 2 answers (order 4 is left out). docs/theory/truth.md (15)
class CoilTruth {
 public:
  CoilTruth(const base::CoilGeometry& coil, int index, const Vec3& axis_base, double strength, double core_radius_m,
            double core_kappa, const Vec3& core_centre_base_m = {});

  // Sum over all turns + core series: exact everywhere outside the core, slow.
  Vec3 FieldByTurns(const Vec3& point_base_m) const noexcept;
  // Outside the windings only.
  Vec3 FieldBySeries(const Vec3& point_base_m) const noexcept {
    if (core_is_centred_) return total_.Field(point_base_m);
    return turns_series_.Field(point_base_m) + CoreField(point_base_m);
  }
  // The same where each charge lies. `fields_T` is of the charges' size.
  void FieldsBySeries(const Charges& charges, FieldArray& fields_T) const noexcept;
  const ZonalSeries& series() const noexcept { return total_; }
  double moment_Am2() const noexcept { return total_.moment_Am2(); }
  double core_moment_Am2() const noexcept { return core_.moment_Am2(); }
  const Vec3& axis_base() const noexcept { return axis_; }

 private:
  Vec3 FieldOfTurns(const Vec3& point_base_m) const noexcept;  // alone
  Vec3 CoreField(const Vec3& point_base_m) const noexcept;
  Vec3 Order2(const Vec3& from_core_m) const noexcept;  // of the core that is off its centre

  std::vector<Turn> turns_;
  Vec3 axis_;
  double strength_;
  Vec3 core_centre_base_m_;
  bool core_is_centred_;
  std::array<Vec3, 3> order_2_T_m4_;  // columns of kappa_2 a^5 times the gradient in the core's centre
  ZonalSeries core_;
  ZonalSeries total_;
  ZonalSeries turns_series_;  // the winding's alone, if the core is off its centre
};

}  // namespace omni::sim
