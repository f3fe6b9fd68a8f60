// The truth's static fields against converged quadrature and the series of a sphere of finite permeability.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "service/sim/fields/charge_kernel.h"
#include "service/sim/fields/random.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig.h"

namespace omni::sim {
namespace test_sim_core_series {

constexpr double kCore_m = 0.015;

double RelativeError(const Vec3& value, const Vec3& reference) { return Norm(value - reference) / Norm(reference); }

double KappaOf(double mu) { return (mu - 1) / (mu + 2); }

// Response of a sphere to a charge q at r0 [Stratton 3.23]: phi = -1e-7 q sum kappa_l a^(2l+1) / (r0^(l+1) r^(l+1))
// P_l, kappa_l = l (mu - 1) / (l (mu + 1) + 1), and B = -grad phi, summed until nothing changes.
Vec3 SeriesAnswer(const Vec3& source, double q, double mu, const Vec3& point) {
  const double r0 = Norm(source);
  const double r = Norm(point);
  const Vec3 n = (1 / r) * point;
  const Vec3 n0 = (1 / r0) * source;
  const double c = Dot(n, n0);
  double p_before = 1;
  double p = c;
  double d_before = 0;
  double d = 1;
  double radial = 0;
  double across = 0;
  double power = kCore_m * kCore_m * kCore_m / (r0 * r0 * r * r * r);
  for (int l = 1; l < 400; ++l) {
    const double kappa = l * (mu - 1) / (l * (mu + 1) + 1);
    radial -= kappa * power * (l + 1) * p;  // -d/dr of r^-(l+1) is (l+1) r^-(l+2)
    across += kappa * power * d;            // the rest of the gradient: P' (n0 - c n) / r
    const double p_next = ((2 * l + 1) * c * p - l * p_before) / (l + 1);
    const double d_next = d_before + (2 * l + 1) * p;
    p_before = p;
    p = p_next;
    d_before = d;
    d = d_next;
    power *= kCore_m * kCore_m / (r0 * r);
  }
  return (1e-7 * q) * (radial * n + across * (n0 - c * n));
}

Charges OneCharge(const Vec3& at, double q) {
  Charges charges;
  charges.Resize(1);
  charges.x[0] = at.x;
  charges.y[0] = at.y;
  charges.z[0] = at.z;
  charges.q[0] = q;
  return charges;
}

Charges ImagesOf(const Charges& charges, double kappa) {
  const CoreImages core(kCore_m, kappa);
  Charges images;
  images.Resize(core.image_count(charges.size()));
  core.PlaceImages(charges, images);
  return images;
}

// At the sensors and as near as the magnet gets.
TEST(SimCoreSeries, ChargeImagesMatchAPermeableSphere) {
  Random random(31);
  for (const double mu : {4.0, 9.0, 100.0, 998.0, 1e5}) {
    double worst_far = 0;
    double worst_near = 0;
    for (int i = 0; i < 200; ++i) {
      const Vec3 source = random.Uniform(0.038, 0.12) * Normalized(random.NormalVector(1));
      const Vec3 n = Normalized(random.NormalVector(1));
      const Charges images = ImagesOf(OneCharge(source, 3.0), KappaOf(mu));
      const Vec3 far = 0.096 * n;
      const Vec3 near = 0.038 * n;
      worst_far = std::max(worst_far, RelativeError(FieldOf(images, far), SeriesAnswer(source, 3.0, mu, far)));
      worst_near = std::max(worst_near, RelativeError(FieldOf(images, near), SeriesAnswer(source, 3.0, mu, near)));
    }
    EXPECT_LT(worst_far, 1e-7) << "mu " << mu;
    EXPECT_LT(worst_near, 1e-4 / mu) << "mu " << mu;
  }
}

TEST(SimCoreSeries, NonmagneticCoreHasNoImageField) {
  const Charges images = ImagesOf(OneCharge({0, 0.01, 0.05}, 2.0), 0.0);
  EXPECT_EQ(Norm(FieldOf(images, {0, 0, 0.06})), 0);
}

// A dipole is two charges: the series of the pair.
TEST(SimCoreSeries, DipoleImagesMatchTheSphereSeries) {
  const double mu = 500;
  const double h = 1e-4;
  const Vec3 at{0.01, -0.02, 0.05};
  const Vec3 u = base::Normalized({1, 2, 3});
  Charges pair;
  pair.Resize(2);
  for (std::size_t i = 0; i < 2; ++i) {
    const double sign = i == 0 ? 1 : -1;
    const Vec3 p = at + (sign * h) * u;
    pair.x[i] = p.x;
    pair.y[i] = p.y;
    pair.z[i] = p.z;
    pair.q[i] = sign * 1000;
  }
  const Charges images = ImagesOf(pair, KappaOf(mu));
  for (const Vec3& p : {Vec3{0.06, 0, -0.075}, Vec3{0, 0, 0.04}, Vec3{-0.05, 0.02, -0.01}}) {
    const Vec3 series = SeriesAnswer(pair.position(0), 1000, mu, p) + SeriesAnswer(pair.position(1), -1000, mu, p);
    EXPECT_LT(RelativeError(FieldOf(images, p), series), 1e-6);
  }
}

// Inside the core the potential of order l is c r^l P_l, so that on its surface B_n = mu l times the coefficient of
// B_t: normal B and tangential H are continuous. Coefficients by projection with the midpoint rule in the angle.
TEST(SimCoreSeries, CoilFieldMeetsBoundaryConditionsOfAPermeableCore) {
  const double mu = 9;
  const std::vector<Turn> turns{{0.028, 0.009}, {0.028, -0.009}, {0.02, 0.004}, {0.02, -0.004}};
  const ZonalSeries core(ZonalSeries::Expand(turns, kCore_m, KappaOf(mu)).core, {0, 0, 1});
  constexpr int kSteps = 4000;
  for (const int order : {1, 3, 5}) {
    double normal = 0;
    double tangential = 0;
    for (int i = 0; i < kSteps; ++i) {
      const double theta = 3.14159265358979 * (i + 0.5) / kSteps;
      const Vec3 n{std::sin(theta), 0, std::cos(theta)};
      const Vec3 t{std::cos(theta), 0, -std::sin(theta)};
      const Vec3 p = kCore_m * n;
      Vec3 b = core.Field(p);
      for (const Turn& turn : turns) {
        const CylinderField field = TurnField(turn.radius_m, p.x, p.z - turn.height_m);
        b += Vec3{field.rho_T, 0, field.z_T};
      }
      const double c = n.z;
      const double c2 = c * c;
      const double legendre = order == 1   ? c
                              : order == 3 ? 0.5 * c * (5 * c2 - 3)
                                           : c * (63 * c2 * c2 - 70 * c2 + 15) / 8;
      const double slope = order == 1   ? 1
                           : order == 3 ? 1.5 * (5 * c2 - 1)
                                        : (315 * c2 * c2 - 210 * c2 + 15) / 8;  // dP/dc; dP/dtheta = -sin theta dP/dc
      normal += Dot(b, n) * legendre * n.x;
      tangential += Dot(b, t) * (-n.x * slope) * n.x / (order * (order + 1));
    }
    EXPECT_NEAR(normal / (mu * order * tangential), 1, 1e-4) << "order " << order;
  }
}

// What a sensor reads, against ten times as many charges for the magnet and its images.
TEST(SimCoreSeries, SensorFieldsAreConverged) {
  const base::DeviceGeometry device = support::NominalDevice();
  Rig rig(device, {.sizes = NoImperfections(), .noise = NoiseMode::kNone});
  const MagnetFaces faces(device.magnet, 12, 48);
  const CoreImages core(device.core_radius_m, device.core_kappa);
  Charges magnet;
  magnet.Resize(faces.charge_count());
  Charges images;
  images.Resize(core.image_count(magnet.size()));
  Random random(32);
  double worst = 0;
  for (int i = 0; i < 100; ++i) {
    const MagnetPose pose = rig.DrawPose({.radius_max_m = 0.06, .tilt_max_rad = 3.1}, random);
    faces.PlaceCharges(pose, magnet);
    core.PlaceImages(magnet, images);
    const SensorFields fields = rig.Readings(&pose, {});
    for (std::size_t s = 0; s < fields.size(); ++s) {
      const Vec3& at = device.sensors[s].position_base_m;
      worst = std::max(worst, RelativeError(fields[s], FieldOf(magnet, at) + FieldOf(images, at)));
    }
  }
  EXPECT_LT(worst, 1e-7);
}

// For the benchmarks: another magnet reads differently.
TEST(SimCoreSeries, OnePercentWiderMagnetReadsTwoPercentMore) {
  base::DeviceGeometry device = support::NominalDevice();
  Rig rig(device, {.sizes = NoImperfections(), .noise = NoiseMode::kNone});
  device.magnet.radius_m *= 1.01;
  Rig wider(device, {.sizes = NoImperfections(), .noise = NoiseMode::kNone});
  const MagnetPose pose{{0.01, 0.02, 0.06}, base::Normalized({0.1, 0.2, -1})};
  const Vec3 b = rig.Readings(&pose, {})[3];
  EXPECT_NEAR(Norm(wider.Readings(&pose, {})[3]) / Norm(b), 1.0201, 1e-3);
}

// A uniform background and the core's response: the field is normal to an infinitely permeable surface.
TEST(SimCoreSeries, BackgroundFieldIsNormalToAPerfectCore) {
  base::DeviceGeometry device = support::NominalDevice();
  device.core_kappa = 1;
  for (base::SensorGeometry& sensor : device.sensors) {
    const Vec3 n = Normalized(sensor.position_base_m);
    sensor.position_base_m = device.core_radius_m * n;
  }
  Rig rig(device, {.sizes = NoImperfections(), .noise = NoiseMode::kNone});
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const std::array<Vec3, 3> columns = rig.truth().UniformResponse(i);
    const Vec3 b = 1e-5 * columns[0] + 3e-5 * columns[1] - 4e-5 * columns[2];
    const Vec3 n = Normalized(device.sensors[i].position_base_m);
    EXPECT_LT(Norm(b - Dot(b, n) * n), 1e-12 * 1e-5 + 1e-9 * Norm(b));
  }
}

TEST(SimChargeKernel, ChargeSumsAreBitIdenticalOnAllProcessors) {
  Random random(33);
  std::vector<double> x(64), y(64), z(64), q(64);
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = random.Uniform(-0.02, 0.02);
    y[i] = random.Uniform(-0.02, 0.02);
    z[i] = random.Uniform(-0.02, 0.02);
    q[i] = random.Uniform(-50, 50);
  }
  const double point[3] = {0.05, -0.03, 0.07};
  double baseline[3];
  double fastest[3];
  ChargeSumBaseline(x.data(), y.data(), z.data(), q.data(), x.size(), point, baseline);
  FastestChargeSum()(x.data(), y.data(), z.data(), q.data(), x.size(), point, fastest);
  double plain[3] = {};
  for (std::size_t i = 0; i < x.size(); ++i) {
    const Vec3 d{point[0] - x[i], point[1] - y[i], point[2] - z[i]};
    const double k = q[i] / std::pow(Norm(d), 3);
    plain[0] += k * d.x;
    plain[1] += k * d.y;
    plain[2] += k * d.z;
  }
  for (int axis = 0; axis < 3; ++axis) {
    EXPECT_EQ(baseline[axis], fastest[axis]);
    EXPECT_NEAR(baseline[axis] / plain[axis], 1, 1e-11);
  }
}

TEST(SimChargeKernel, CoilFieldsAreBitIdenticalOnAllProcessors) {
  Random random(34);
  ZonalTerms terms{.axis = {0.6, 0, 0.8}, .reference_m = 0.04};
  for (double& scaled : terms.scaled) scaled = random.Uniform(-1, 1);
  std::array<std::array<double, 64>, 3> at;
  for (auto& axis : at)
    for (double& coordinate : axis) coordinate = random.Uniform(0.03, 0.08);
  std::array<std::array<double, 64>, 3> baseline;
  std::array<std::array<double, 64>, 3> fastest;
  ZonalFieldsBaseline(terms, at[0].data(), at[1].data(), at[2].data(), 64, baseline[0].data(), baseline[1].data(),
                      baseline[2].data());
  FastestZonalFields()(terms, at[0].data(), at[1].data(), at[2].data(), 64, fastest[0].data(), fastest[1].data(),
                       fastest[2].data());
  EXPECT_EQ(baseline, fastest);
}

}  // namespace test_sim_core_series
}  // namespace omni::sim
