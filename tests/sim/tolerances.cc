// A base and pen built within tolerances: radius of the hull, place and size of the core, size of the magnet.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "service/sim/fields/imperfections.h"
#include "service/sim/fields/truth_model.h"
#include "service/sim/fields/winding.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::sim {
namespace test_sim_tolerances {

const Vec3 kOffset_m{3e-4, -2e-4, 3.5e-4};
const MagnetPose kPose{{0.01, -0.02, 0.06}, Normalized(Vec3{0.2, 0.1, -1})};

// Without coils, a core off centre is a centred core with everything else moved the other way.
TEST(SimTolerances, OffCentreCoreEqualsMovingEverythingElse) {
  const base::DeviceGeometry device = support::NominalDevice();
  Imperfections off, moved;
  off.core_offset_base_m = kOffset_m;
  for (SensorError& sensor : moved.sensors) sensor.position_base_m = -kOffset_m;
  TruthModel a(device, off, false), b(device, moved, false);
  const MagnetPose pose_b{kPose.centre_base_m - kOffset_m, kPose.axis_base};
  Surroundings around;
  around.background_base_T = {2e-5, 0, -4e-5};
  around.core_moment_Am2 = {0.01, 0.02, -0.01};
  const SensorFields of_a = a.AllSensorFields(&kPose, {}, around), of_b = b.AllSensorFields(&pose_b, {}, around);
  for (std::size_t i = 0; i < of_a.size(); ++i) EXPECT_LT(Norm(of_a[i] - of_b[i]), 1e-12 * Norm(of_a[i]) + 1e-18);
  const ForceMap forces_a = a.ForcesAt(kPose), forces_b = b.ForcesAt(pose_b);
  EXPECT_LT(Norm(forces_a.core.force_N - forces_b.core.force_N), 1e-10 * Norm(forces_b.core.force_N));
  EXPECT_LT(Norm(forces_a.dipole[1].force_N - forces_b.dipole[1].force_N), 1e-10 * Norm(forces_b.dipole[1].force_N));
}

// Response of iron of infinite permeability to turns, by orders of its own sphere: its potential cancels theirs there,
//   psi(p) = sum_l a / l (a / r)^(l+1) (2 l + 1) / 4 pi int B_r P_l(cos gamma) dOmega   [Jackson 3e, 3.62]
class IronAnswer {
 public:
  IronAnswer(const CoilTruth& turns, const Vec3& centre_base_m, double radius_m)
      : centre_(centre_base_m), a_(radius_m) {
    for (int i = 0; i < kPoints; ++i) {  // evenly over the sphere [Fibonacci lattice]
      const double z = -1 + 2 * (i + 0.5) / kPoints, angle = i * std::numbers::pi * (3 - std::sqrt(5.0));
      const double rho = std::sqrt(1 - z * z);
      normal_.push_back({rho * std::cos(angle), rho * std::sin(angle), z});
      radial_T_.push_back(Dot(turns.FieldByTurns(centre_ + a_ * normal_.back()), normal_.back()));
    }
  }
  Vec3 Field(const Vec3& p) const {
    constexpr double h_m = 1e-4;
    const auto slope = [&](const Vec3& e) { return (Potential(p + h_m * e) - Potential(p - h_m * e)) / (2 * h_m); };
    return {-slope({1, 0, 0}), -slope({0, 1, 0}), -slope({0, 0, 1})};
  }

 private:
  static constexpr int kPoints = 6000, kOrder = 12;
  double Potential(const Vec3& p) const {
    const Vec3 d = p - centre_;
    const double r = Norm(d);
    double sum = 0;
    for (std::size_t i = 0; i < normal_.size(); ++i) {
      const double c = Dot(normal_[i], d) / r;
      double before = 1, legendre = c, of_point = 0;
      for (int l = 1; l <= kOrder; ++l) {
        of_point += a_ / l * std::pow(a_ / r, l + 1) * (2 * l + 1) * legendre;
        const double next = ((2 * l + 1) * c * legendre - l * before) / (l + 1);
        before = legendre;
        legendre = next;
      }
      sum += radial_T_[i] * of_point / kPoints;
    }
    return sum;
  }
  Vec3 centre_;
  double a_;
  std::vector<Vec3> normal_;
  std::vector<double> radial_T_;
};

TEST(SimTolerances, OffCentreCoreRespondsToTheCoilsFromItsPosition) {
  const base::DeviceGeometry device = support::NominalDevice();
  for (int k = 0; k < 3; ++k) {
    const base::CoilGeometry& drawn = device.coils[static_cast<std::size_t>(k)];
    const CoilTruth turns(drawn, k, drawn.axis_base, 1, device.core_radius_m, 0);
    const CoilTruth centred(drawn, k, drawn.axis_base, 1, device.core_radius_m, 1);
    const CoilTruth off(drawn, k, drawn.axis_base, 1, device.core_radius_m, 1, kOffset_m);
    const IronAnswer answer(turns, kOffset_m, device.core_radius_m);
    for (const Vec3& p : {Vec3{0.03, 0.01, 0.035}, Vec3{-0.02, 0.05, 0.02}, device.sensors[2].position_base_m}) {
      const Vec3 exact_T = turns.FieldByTurns(p) + answer.Field(p);
      const double wrong_T = Norm(off.FieldByTurns(p) - exact_T);
      EXPECT_LT(wrong_T, 1e-3 * Norm(exact_T)) << k;
      EXPECT_GT(Norm(centred.FieldByTurns(p) - exact_T), 4 * wrong_T) << "what a core in its place gets wrong";
    }
  }
}

TEST(SimTolerances, SeriesMatchesTurnsWithAnOffCentreCore) {
  const base::DeviceGeometry device = support::NominalDevice();
  const CoilTruth off(device.coils[1], 1, device.coils[1].axis_base, 1, device.core_radius_m, device.core_kappa,
                      kOffset_m);
  for (const Vec3& p : {Vec3{0.06, 0.01, 0.02}, Vec3{0, -0.03, 0.07}, Vec3{0.1, 0.1, -0.05}}) {
    EXPECT_LT(Norm(off.FieldBySeries(p) - off.FieldByTurns(p)), 1e-4 * Norm(off.FieldByTurns(p)));
  }
}

TEST(SimTolerances, DrawnSizesHaveTheirSpreadAndKeepTheMoment) {
  const base::DeviceGeometry device = support::NominalDevice();
  ImperfectionSizes sizes = NoImperfections();
  sizes.hull_radius_m = 3e-4;
  sizes.core_offset_m = 2e-4;
  sizes.core_size = 0.01;
  sizes.magnet_size = 0.02;
  sizes.tip_offset_m = 1e-3;
  Random random(8);
  double hull_m2 = 0, offset_m2 = 0, tip_m2 = 0;
  constexpr int kDraws = 2000;
  for (int i = 0; i < kDraws; ++i) {
    const Imperfections drawn = DrawImperfections(sizes, random);
    hull_m2 += drawn.hull_radius_m * drawn.hull_radius_m / kDraws;
    offset_m2 += Dot(drawn.core_offset_base_m, drawn.core_offset_base_m) / kDraws;
    tip_m2 += drawn.tip_offset_m * drawn.tip_offset_m / kDraws;
    const base::DeviceGeometry made = TrueSizes(device, drawn);
    ASSERT_EQ(made.magnet.tip_offset_m, device.magnet.tip_offset_m + drawn.tip_offset_m);
    const auto moment = [](const base::MagnetGeometry& m) {
      return m.remanence_T * m.radius_m * m.radius_m * m.half_height_m;
    };
    ASSERT_NEAR(moment(made.magnet), moment(device.magnet), 1e-12 * moment(device.magnet));
    ASSERT_EQ(made.hull_radius_m, device.hull_radius_m + drawn.hull_radius_m);
    ASSERT_NE(made.magnet.radius_m, device.magnet.radius_m);
  }
  EXPECT_NEAR(std::sqrt(hull_m2), 3e-4, 2e-5);
  EXPECT_NEAR(std::sqrt(offset_m2), std::sqrt(3.0) * 2e-4, 2e-5);
  EXPECT_NEAR(std::sqrt(tip_m2), 1e-3, 7e-5);
}

}  // namespace test_sim_tolerances
}  // namespace omni::sim
