// Laws that every field here must obey, at seeded random places; errors are relative.
#include <gtest/gtest.h>

#include <cmath>

#include "service/base/eigen.h"
#include "service/magnetics/coil.h"
#include "service/magnetics/dipole.h"
#include "service/magnetics/disc_magnet.h"
#include "service/magnetics/zonal.h"
#include "tests/support/core_image.h"
#include "tests/support/numeric.h"
#include "tests/support/rig/magnet_truth.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::magnetics {
namespace test_magnetics_fields {

using Eigen::Matrix3d;
using Eigen::Vector3d;
using support::CoreImage;
using support::CoreImageField;
using support::CoreImageGradient;
using support::ImageInCore;
using support::NumericJacobian;
using support::RandomUnit;
using support::RelativeError;
using support::Rng;
using support::Uniform;

constexpr int kPoses = 1000;
constexpr double kStep = 1e-3;  // of the distance: truncation and rounding both below 1e-9
constexpr double kTolerance = 1e-7;

// div B = trace, curl B = antisymmetric part.
void ExpectSourceFree(const Matrix3d& G) {
  EXPECT_LT(std::abs(G.trace()), 1e-12 * G.norm());
  EXPECT_LT((G - G.transpose()).norm(), 1e-12 * G.norm());
}

TEST(MagneticsFields, GradientsMatchFiniteDifferencesAndAreSourceFree) {
  Rng rng(1);
  for (int i = 0; i < kPoses; ++i) {
    const double r = Uniform(rng, 0.02, 0.2);
    const Vector3d d = r * RandomUnit(rng), m = RandomUnit(rng) * Uniform(rng, 0.1, 5), u = RandomUnit(rng);
    const std::array<double, 5> q{1.0, Uniform(rng, -1, 1) * r * r, Uniform(rng, -1, 1) * std::pow(r, 4),
                                  Uniform(rng, -1, 1) * std::pow(r, 6), Uniform(rng, -1, 1) * std::pow(r, 8)};
    const double h = kStep * r;
    const auto dipole = [&](const Vector3d& x) { return DipoleField(m, x); };
    const auto charge = [&](const Vector3d& x) { return ChargeField(3, x); };
    const auto zonal = [&](const Vector3d& x) { return ZonalField(q, u, x); };
    EXPECT_LT(RelativeError(DipoleGradient(m, d), NumericJacobian(dipole, d, h)), kTolerance);
    EXPECT_LT(RelativeError(ChargeGradient(3, d), NumericJacobian(charge, d, h)), kTolerance);
    EXPECT_LT(RelativeError(ZonalGradient(q, u, d), NumericJacobian(zonal, d, h)), kTolerance);
    ExpectSourceFree(DipoleGradient(m, d));
    ExpectSourceFree(ChargeGradient(3, d));
    ExpectSourceFree(ZonalGradient(q, u, d));
    EXPECT_LT(RelativeError(DipoleMatrix(d) * m, DipoleField(m, d)), 1e-13);
  }
}

TEST(MagneticsFields, ZonalAxisDerivativeMatchesFiniteDifferences) {
  Rng rng(2);
  for (int i = 0; i < kPoses; ++i) {
    const double r = Uniform(rng, 0.03, 0.2);
    const Vector3d d = r * RandomUnit(rng), u = RandomUnit(rng);
    const std::array<double, 3> q{1.0, Uniform(rng, -1, 1) * r * r, Uniform(rng, -1, 1) * std::pow(r, 4)};
    const TangentBasis e = MakeTangentBasis(u);
    const double h = 1e-3;
    for (const Vector3d& t : {e.e1, e.e2}) {
      const auto turned = [&](double a) { return ZonalField(q, std::cos(a) * u + std::sin(a) * t, d); };
      const Vector3d numeric = (8 * (turned(h) - turned(-h)) - (turned(2 * h) - turned(-2 * h))) / (12 * h);
      EXPECT_LT((ZonalAxisDerivative(q, u, d) * t - numeric).norm(), 1e-8 * ZonalField(q, u, d).norm() * 10);
    }
  }
}

TEST(MagneticsFields, ZonalFieldIsNegativeGradientOfItsPotential) {
  Rng rng(3);
  for (int i = 0; i < kPoses; ++i) {
    const double r = Uniform(rng, 0.02, 0.2), h = kStep * r;
    const Vector3d d = r * RandomUnit(rng), u = RandomUnit(rng), e = u.unitOrthogonal();
    const std::array<double, 3> q{1.0, Uniform(rng, -1, 1) * r * r, Uniform(rng, -1, 1) * std::pow(r, 4)};
    const auto potential = [&](const Vector3d& axis, const Vector3d& x) {
      return ZonalPotential(q, axis.normalized(), x);
    };
    const auto slope = [](double p2, double p1, double m1, double m2, double step) {
      return (8 * (p1 - m1) - (p2 - m2)) / (12 * step);
    };
    Vector3d gradient;
    for (int c = 0; c < 3; ++c) {
      const Vector3d s = h * Vector3d::Unit(c);
      gradient[c] =
          slope(potential(u, d + 2 * s), potential(u, d + s), potential(u, d - s), potential(u, d - 2 * s), h);
    }
    EXPECT_LT(RelativeError(ZonalField(q, u, d), -gradient), kTolerance);
    const double by_turn = slope(potential(u + 2 * kStep * e, d), potential(u + kStep * e, d),
                                 potential(u - kStep * e, d), potential(u - 2 * kStep * e, d), kStep);
    EXPECT_NEAR(ZonalPotentialAxisDerivative(q, u, d).dot(e), by_turn, 1e-5 * gradient.norm() * r);
  }
}

TEST(MagneticsFields, FirstOrderZonalFieldIsTheDipoleField) {
  Rng rng(3);
  for (int i = 0; i < 100; ++i) {
    const Vector3d d = Uniform(rng, 0.02, 0.2) * RandomUnit(rng), u = RandomUnit(rng);
    const std::array<double, 1> q{2.5};
    EXPECT_LT(RelativeError(ZonalField(q, u, d), DipoleField(2.5 * u, d)), 1e-13);
    EXPECT_LT(RelativeError(ZonalGradient(q, u, d), DipoleGradient(2.5 * u, d)), 1e-13);
  }
}

TEST(MagneticsFields, DipoleAndImageFieldsAreReciprocal) {
  // Reciprocity: the work of dipole 1 in the field of 2 is that of 2 in the field of 1, with and without the core.
  Rng rng(4);
  for (int i = 0; i < kPoses; ++i) {
    const Vector3d p1 = Uniform(rng, 0.03, 0.1) * RandomUnit(rng), p2 = Uniform(rng, 0.03, 0.1) * RandomUnit(rng);
    if ((p1 - p2).norm() < 0.01) continue;
    const Vector3d m1 = RandomUnit(rng), m2 = RandomUnit(rng);
    EXPECT_NEAR(m1.dot(DipoleField(m2, p1 - p2)), m2.dot(DipoleField(m1, p2 - p1)),
                1e-12 * DipoleField(m2, p1 - p2).norm());
    const Vector3d at_1 = CoreImageField(ImageInCore(m2, p2, 0.015, 1.0), p1);
    const Vector3d at_2 = CoreImageField(ImageInCore(m1, p1, 0.015, 1.0), p2);
    EXPECT_NEAR(m1.dot(at_1), m2.dot(at_2), 1e-10 * at_1.norm());
  }
}

TEST(MagneticsFields, CoreImageGradientMatchesFiniteDifferences) {
  Rng rng(5);
  for (int i = 0; i < kPoses; ++i) {
    const CoreImage image = ImageInCore(RandomUnit(rng), Uniform(rng, 0.03, 0.1) * RandomUnit(rng), 0.015, 0.997);
    const Vector3d x = Uniform(rng, 0.03, 0.1) * RandomUnit(rng);
    const auto field = [&](const Vector3d& at) { return CoreImageField(image, at); };
    EXPECT_LT(RelativeError(CoreImageGradient(image, x), NumericJacobian(field, x, kStep * x.norm())), 1e-6);
    ExpectSourceFree(CoreImageGradient(image, x));
  }
}

TEST(MagneticsFields, FieldIsNormalToTheSurfaceOfAPerfectCore) {
  Rng rng(6);
  const double a = 0.015;
  for (int i = 0; i < kPoses; ++i) {
    const Vector3d p = Uniform(rng, 0.02, 0.1) * RandomUnit(rng), m = RandomUnit(rng), n = RandomUnit(rng);
    const Vector3d B = DipoleField(m, a * n - p) + CoreImageField(ImageInCore(m, p, a, 1.0), a * n);
    EXPECT_LT((B - B.dot(n) * n).norm(), 1e-11 * DipoleField(m, a * n - p).norm());
  }
}

TEST(MagneticsFields, CoilFieldIsNormalToTheCoreSurface) {
  // Orders up to 13 are carried; windings start 0.5 mm outside the core, so a few per mille remain.
  Rng rng(7);
  const base::DeviceGeometry device = support::NominalDevice();
  const auto winding = MakeWinding(device.coils[2], 2);
  const CoilMoments core = CoreMoments(winding, device.core_radius_m, 1.0);
  for (int i = 0; i < 200; ++i) {
    const Vector3d n = RandomUnit(rng);
    const Vector3d B = CoilField(winding, core, Vector3d::UnitZ(), 0.015 * n);
    EXPECT_LT((B - B.dot(n) * n).norm(), 0.01 * 3 * 3.9e-3);  // the pole carries 3 B(0)
  }
}

TEST(MagneticsFields, LoopFieldIsSourceFree) {
  Rng rng(8);
  for (int i = 0; i < kPoses; ++i) {
    const Vector3d axis = RandomUnit(rng), x = Uniform(rng, 0.03, 0.1) * RandomUnit(rng);
    const auto field = [&](const Vector3d& at) { return FieldOfLoop(0.02, 0.005, axis, at); };
    const Matrix3d G = NumericJacobian(field, x, 1e-4);
    EXPECT_LT(std::abs(G.trace()), 1e-7 * G.norm());
    EXPECT_LT((G - G.transpose()).norm(), 1e-7 * G.norm());
  }
}

TEST(MagneticsFields, WindingMultipolesMatchTurnByTurnField) {
  Rng rng(9);
  const base::DeviceGeometry device = support::NominalDevice();
  for (int k = 0; k < 3; ++k) {
    const auto winding = MakeWinding(device.coils[static_cast<std::size_t>(k)], k);
    const CoilMoments coil = WindingMoments(winding);
    const CoilMoments core = CoreMoments(winding, device.core_radius_m, device.core_kappa);
    CoilMoments sum;
    for (std::size_t j = 0; j < sum.size(); ++j) sum[j] = coil[j] + core[j];
    const Vector3d axis = base::ToEigen(device.coils[static_cast<std::size_t>(k)].axis_base);
    for (int i = 0; i < 100; ++i) {
      const Vector3d n = RandomUnit(rng);
      const auto error = [&](double r) {
        const Vector3d exact = CoilField(winding, core, axis, r * n);
        return RelativeError(ZonalField(sum, axis, r * n), exact);
      };
      EXPECT_LT(error(0.096), 1e-6);
      EXPECT_LT(error(0.042), 5e-3);
    }
  }
}

TEST(MagneticsFields, DiscMultipolesMatchChargedFaces) {
  // Relative error of |B| with orders 1, 3, 5: 0.15 % at 41 mm, 0.003 % at 80 mm.
  Rng rng(10);
  const base::MagnetGeometry geometry = support::NominalDevice().magnet;
  const DiscMagnet magnet = MakeDiscMagnet(geometry);
  const auto charges = support::DiscCharges(geometry, 40, 64);
  for (int i = 0; i < 100; ++i) {
    const Vector3d u = RandomUnit(rng), n = RandomUnit(rng);
    const auto error = [&](double r) {
      Vector3d exact = Vector3d::Zero();
      for (const auto& charge : charges) {
        exact += ChargeField(charge.q, r * n - support::ChargePosition(charge, Vector3d::Zero(), u));
      }
      return RelativeError(ZonalField(magnet.zonal, u, r * n), exact);
    };
    EXPECT_LT(error(0.041), 5e-3);
    EXPECT_LT(error(0.080), 2e-4);
  }
}

TEST(MagneticsFields, RingOfPointsReproducesTheDiscOctupole) {
  Rng rng(11);
  const DiscMagnet magnet = MakeDiscMagnet(support::NominalDevice().magnet);
  for (int i = 0; i < 100; ++i) {
    const Vector3d u = RandomUnit(rng), d = 0.08 * RandomUnit(rng);
    const TangentBasis e = MakeTangentBasis(u);
    Vector3d ring = Vector3d::Zero();
    for (const MagnetPoint& point : magnet.points) {
      ring += DipoleField(point.share * magnet.moment_Am2 * u,
                          d - (point.ring_1_m * e.e1 + point.ring_2_m * e.e2 + point.axial_m * u));
    }
    EXPECT_LT(RelativeError(ring, ZonalField(magnet.zonal, u, d)), 1e-3);
    EXPECT_GT(RelativeError(ring, DipoleField(magnet.moment_Am2 * u, d)), 5e-3);  // a bare dipole would not do
  }
}

TEST(MagneticsFields, SnappingForceIsNegativeGradientOfImageEnergy) {
  // U = -m.B_image(p; m, p) / 2: the image moves with the magnet, hence the half.
  Rng rng(12);
  for (int i = 0; i < 200; ++i) {
    const Vector3d p = Uniform(rng, 0.03, 0.08) * RandomUnit(rng), m = 5 * RandomUnit(rng);
    const auto energy = [&](const Vector3d& at) {
      return -0.5 * m.dot(CoreImageField(ImageInCore(m, at, 0.015, 1.0), at));
    };
    Vector3d force;
    const double h = 1e-5;
    for (int k = 0; k < 3; ++k) {
      const Vector3d e = h * Vector3d::Unit(k);
      force[k] = -(8 * (energy(p + e) - energy(p - e)) - (energy(p + 2 * e) - energy(p - 2 * e))) / (12 * h);
    }
    const Vector3d direct = CoreImageGradient(ImageInCore(m, p, 0.015, 1.0), p) * m;
    EXPECT_LT(RelativeError(direct, force), 1e-6);
    EXPECT_LT(direct.dot(p), 0);  // towards the core, whatever the orientation
  }
}

TEST(MagneticsFields, TangentBasisIsOrthonormalRightHandedAndContinuousBelowThePole) {
  Rng rng(13);
  for (int i = 0; i < 10 * kPoses; ++i) {
    const Vector3d pole(0, 0, i % 2 ? 1 : -1);
    const Vector3d u = i < 2 ? pole : i % 10 < 2 ? (pole + 0.03 * RandomUnit(rng)).normalized() : RandomUnit(rng);
    const TangentBasis e = MakeTangentBasis(u);
    EXPECT_LT((e.e1.cross(e.e2) - u).norm(), 1e-11);
    EXPECT_NEAR(e.e1.norm(), 1, 1e-11);
    EXPECT_NEAR(e.e1.dot(u), 0, 1e-11);
    const Vector3d near = (u + 1e-7 * RandomUnit(rng)).normalized();
    if (u.z() < 0.9) {
      EXPECT_LT((MakeTangentBasis(near).e1 - e.e1).norm(), 1e-5);
    }
  }
}

}  // namespace test_magnetics_fields
}  // namespace omni::magnetics
