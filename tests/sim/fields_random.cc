// Laws of physics over seeded random poses: div B = 0, curl B = 0, force = -grad energy, torque = -d energy / d angle.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "service/sim/fields/random.h"
#include "service/sim/fields/truth_model.h"
#include "tests/support/rig/nominal_device.h"

namespace omni::sim {
namespace test_sim_fields_random {

using Field = std::function<Vec3(const Vec3&)>;

Vec3 RandomDirection(Random& random) {
  Vec3 v;
  do {
    v = random.NormalVector(1);
  } while (!(Norm(v) > 1e-3));
  return Normalized(v);
}

// A pose outside the hull, above the base, any tilt that fits.
MagnetPose RandomPose(Random& random, const base::DeviceGeometry& device) {
  for (;;) {
    Vec3 direction = RandomDirection(random);
    direction.z = std::abs(direction.z);
    const MagnetPose pose{random.Uniform(0.041, 0.1) * direction, RandomDirection(random)};
    if (GapToHull(device.magnet, device.hull_radius_m, pose).gap_m > 1e-3) return pose;
  }
}

struct Derivatives {
  double divergence = 0;
  Vec3 curl;
  double scale = 0;  // largest derivative
};

// Five-point central differences: error h^4.
Derivatives Differentiate(const Field& field, const Vec3& p, double h) {
  std::array<std::array<double, 3>, 3> d{};  // d[i][j] = dB_i / dx_j
  const std::array<Vec3, 3> steps{Vec3{h, 0, 0}, Vec3{0, h, 0}, Vec3{0, 0, h}};
  Derivatives result;
  for (std::size_t j = 0; j < 3; ++j) {
    const Vec3 slope = (1 / (12 * h)) * (8.0 * (field(p + steps[j]) - field(p - steps[j])) -
                                         (field(p + 2.0 * steps[j]) - field(p - 2.0 * steps[j])));
    d[0][j] = slope.x;
    d[1][j] = slope.y;
    d[2][j] = slope.z;
    result.scale = std::max(result.scale, Norm(slope));
  }
  result.divergence = d[0][0] + d[1][1] + d[2][2];
  result.curl = {d[2][1] - d[1][2], d[0][2] - d[2][0], d[1][0] - d[0][1]};
  return result;
}

TEST(SimFieldsProperty, MagnetAndCoilFieldsAreDivergenceAndCurlFree) {
  const base::DeviceGeometry device = support::NominalDevice();
  TruthModel truth(device, Imperfections{}, false);
  const MagnetFaces faces(device.magnet, 6, 16);
  Charges charges;
  charges.Resize(faces.charge_count());
  const CoreImages core(device.core_radius_m, device.core_kappa);
  Charges images;
  images.Resize(core.image_count(charges.size()));
  Random random(11);
  for (int i = 0; i < 40; ++i) {
    faces.PlaceCharges(RandomPose(random, device), charges);
    core.PlaceImages(charges, images);
    const Vec3 p = random.Uniform(0.09, 0.13) * -1.0 * Vec3{0, 0, 1} + random.NormalVector(0.03);
    const std::array<Field, 3> fields{[&](const Vec3& x) { return FieldOf(charges, x) + FieldOf(images, x); },
                                      [&](const Vec3& x) { return truth.coils()[i % 3].FieldByTurns(x); },
                                      [&](const Vec3& x) { return truth.coils()[i % 3].FieldBySeries(x); }};
    if (!(Norm(p) > 0.045)) continue;
    for (std::size_t f = 0; f < fields.size(); ++f) {
      const Derivatives d = Differentiate(fields[f], p, 1e-3);
      EXPECT_LT(std::abs(d.divergence), 1e-5 * d.scale) << "field " << f << " round " << i;
      EXPECT_LT(Norm(d.curl), 1e-5 * d.scale) << "field " << f << " round " << i;
    }
  }
}

// Energy of the magnet in a coil's field at 1 A: U = -integral M . B dV, Gauss in height x nodes of the faces.
double EnergyInCoil(const base::DeviceGeometry& device, const CoilTruth& coil, const MagnetPose& pose) {
  constexpr std::array<double, 3> kPosition{-0.7745966692414834, 0, 0.7745966692414834};
  constexpr std::array<double, 3> kWeight{5.0 / 9, 8.0 / 9, 5.0 / 9};
  double sum = 0;
  for (std::size_t s = 0; s < 3; ++s) {
    base::MagnetGeometry slice = device.magnet;
    slice.half_height_m = 0;  // both faces on the slice: the first half of the charges has the weights M dA
    const MagnetFaces faces(slice, 5, 12);
    Charges nodes;
    nodes.Resize(faces.charge_count());
    faces.PlaceCharges(
        {pose.centre_base_m + (kPosition[s] * device.magnet.half_height_m) * pose.axis_base, pose.axis_base}, nodes);
    for (std::size_t i = 0; i < nodes.size() / 2; ++i) {
      sum -= nodes.q[i] * kWeight[s] * device.magnet.half_height_m *
             Dot(pose.axis_base, coil.FieldBySeries(nodes.position(i)));
    }
  }
  return sum;
}

// Energy of the magnet with its own image: U = 1/2 sum q phi_image, phi = mu0 / 4 pi sum q' / d.
double EnergyInCore(const base::DeviceGeometry& device, const MagnetPose& pose) {
  const MagnetFaces faces(device.magnet, 4, 10);
  Charges charges;
  charges.Resize(faces.charge_count());
  faces.PlaceCharges(pose, charges);
  const CoreImages core(device.core_radius_m, device.core_kappa);
  Charges images;
  images.Resize(core.image_count(charges.size()));
  core.PlaceImages(charges, images);
  double sum = 0;
  for (std::size_t i = 0; i < charges.size(); ++i) {
    for (std::size_t j = 0; j < images.size(); ++j) {
      sum += 0.5e-7 * charges.q[i] * images.q[j] / Norm(charges.position(i) - images.position(j));
    }
  }
  return sum;
}

using Energy = std::function<double(const MagnetPose&)>;

Vec3 MinusGradient(const Energy& energy, const MagnetPose& pose) {
  const double h = 2e-5;
  const auto slope = [&](const Vec3& step) {
    const double up = energy({pose.centre_base_m + step, pose.axis_base});
    const double down = energy({pose.centre_base_m - step, pose.axis_base});
    return (down - up) / (2 * h);
  };
  return {slope({h, 0, 0}), slope({0, h, 0}), slope({0, 0, h})};
}

Vec3 MinusTurnGradient(const Energy& energy, const MagnetPose& pose) {
  const double h = 1e-3;
  const auto slope = [&](const Vec3& turn) {
    const double up = energy({pose.centre_base_m, Rotated(pose.axis_base, turn)});
    const double down = energy({pose.centre_base_m, Rotated(pose.axis_base, -turn)});
    return (down - up) / (2 * h);
  };
  return {slope({h, 0, 0}), slope({0, h, 0}), slope({0, 0, h})};
}

TEST(SimFieldsProperty, ForceAndTorqueAreGradientsOfTheEnergy) {
  base::DeviceGeometry device = support::NominalDevice();
  TruthModel truth(device, Imperfections{}, false);
  Random random(12);
  for (int i = 0; i < 12; ++i) {
    const MagnetPose pose = RandomPose(random, device);
    const ForceMap map = truth.ForcesAt(pose);
    for (std::size_t k = 0; k < 3; ++k) {
      const Energy energy = [&](const MagnetPose& at) { return EnergyInCoil(device, truth.coils()[k], at); };
      const Vec3 force = MinusGradient(energy, pose);
      const Vec3 torque = MinusTurnGradient(energy, pose);
      EXPECT_LT(Norm(map.coil[k].force_N - force), 1e-3 * Norm(force)) << "coil " << k << " round " << i;
      EXPECT_LT(Norm(map.coil[k].torque_Nm - torque), 1e-3 * Norm(torque)) << "coil " << k << " round " << i;
    }
    const Energy energy = [&](const MagnetPose& at) { return EnergyInCore(device, at); };
    const Vec3 force = MinusGradient(energy, pose);
    EXPECT_LT(Norm(map.core.force_N - force), 1e-3 * Norm(force)) << "core, round " << i;
    const Vec3 torque = MinusTurnGradient(energy, pose);
    EXPECT_LT(Norm(map.core.torque_Nm - torque), 2e-3 * Norm(torque) + 1e-7) << "core, round " << i;
  }
}

// No point of the disc is nearer to the hull than the gap says, and some point is as near.
TEST(SimFieldsProperty, GapIsTheDistanceToTheNearestPoint) {
  const base::DeviceGeometry device = support::NominalDevice();
  Random random(13);
  for (int i = 0; i < 300; ++i) {
    const MagnetPose pose{random.Uniform(0.03, 0.09) * RandomDirection(random), RandomDirection(random)};
    const Gap gap = GapToHull(device.magnet, device.hull_radius_m, pose);
    const Vec3 e1 = Perpendicular(pose.axis_base);
    const Vec3 e2 = Cross(pose.axis_base, e1);
    double nearest_m = 1;
    for (int n = 0; n < 2000; ++n) {
      const double phi = 2 * std::numbers::pi * random.Uniform();
      const double rho = device.magnet.radius_m * std::sqrt(random.Uniform());
      const double z = device.magnet.half_height_m * (n % 2 == 0 ? 1.0 : random.Uniform(-1, 1)) * (n % 4 < 2 ? 1 : -1);
      const Vec3 p = pose.centre_base_m + rho * std::cos(phi) * e1 + rho * std::sin(phi) * e2 + z * pose.axis_base;
      nearest_m = std::min(nearest_m, Norm(p) - device.hull_radius_m);
    }
    EXPECT_GE(nearest_m, gap.gap_m - 1e-12);
    EXPECT_LT(nearest_m, gap.gap_m + 2.5e-3);
    // Moving by -gap along the normal touches and no more.
    const MagnetPose moved{pose.centre_base_m - gap.gap_m * gap.normal_base, pose.axis_base};
    EXPECT_GE(GapToHull(device.magnet, device.hull_radius_m, moved).gap_m, -1e-12);
  }
}

}  // namespace test_sim_fields_random
}  // namespace omni::sim
