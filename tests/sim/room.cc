// Objects and events around a base, against integrals and laws that the simulation does not use.
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "service/sim/coils/effects.h"
#include "service/sim/fields/core_images.h"
#include "service/sim/fields/steel.h"
#include "service/sim/twin/tick_sampler.h"
#include "tests/support/rig/nominal_device.h"
#include "tests/support/rig/rig.h"

namespace omni::sim {
namespace test_sim_room {

constexpr double kPi = std::numbers::pi;
const Vec3 kMoment_Am2{0.4, -0.7, 1.9};
const Vec3 kSource_m{0.01, -0.02, 0.055};

Vec3 OfDipole(const Vec3& p) { return DipoleField(kMoment_Am2, p - kSource_m); }

// Iron of infinite permeability fills z < h. On it the field is normal: twice the source's normal component, from a
// layer of charge whose own field is half of it on either side:   B(p) = 1 / 2 pi int Bz(x) (p - x) / |p - x|^3 dA.
Vec3 LayerField(double h_m, const Vec3& p) {
  Vec3 sum_T;
  constexpr int kRings = 1500, kSpokes = 256;
  const double least_m = 0.01, ratio = 1.006;  // rings grow: the field at 80 m is nothing
  double inner_m = 0, outer_m = least_m / kRings;
  for (int ring = 0; ring < kRings; ++ring) {
    const double rho_m = 0.5 * (inner_m + outer_m);
    const double area_m2 = kPi * (outer_m * outer_m - inner_m * inner_m) / kSpokes;
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      const double angle = 2 * kPi * (spoke + 0.5) / kSpokes;
      const Vec3 x{kSource_m.x + rho_m * std::cos(angle), kSource_m.y + rho_m * std::sin(angle), h_m};
      const Vec3 d = p - x;
      const double r = Norm(d);
      sum_T += (OfDipole(x).z * area_m2 / (2 * kPi * r * r * r)) * d;
    }
    inner_m = outer_m;
    outer_m = inner_m + std::max(least_m / kRings, (ratio - 1) * inner_m);
  }
  return sum_T;
}

TEST(SimSteel, PlaneMirrorImageMatchesItsLayerOfCharge) {
  for (const double h_m : {-0.115, -0.3}) {
    for (const double strength : {1.0, 0.4}) {
      const SteelPiece plane({.position_base_m = {0.2, -0.1, h_m}, .strength = strength});
      for (const Vec3& p : {Vec3{0, 0, 0}, Vec3{0.08, 0.03, -0.02}, Vec3{-0.05, 0.06, 0.09}}) {
        const Vec3 layer_T = strength * LayerField(h_m, p);
        EXPECT_LT(Norm(SteelPiece::Answer(plane, OfDipole).FieldAt(p) - layer_T), 3e-3 * Norm(layer_T)) << h_m;
      }
    }
  }
}

TEST(SimSteel, PlaneCancelsTheTangentialField) {
  const Vec3 normal = Normalized(Vec3{0.3, -0.2, 1});
  const SteelPiece wall({.position_base_m = {0, 0, -0.2}, .direction_base = normal});
  for (const double across_m : {-0.1, 0.0, 0.2}) {
    const Vec3 p = Vec3{0, 0, -0.2} + across_m * Perpendicular(normal);
    const Vec3 total_T = OfDipole(p) + SteelPiece::Answer(wall, OfDipole).FieldAt(p);
    EXPECT_LT(Norm(total_T - Dot(total_T, normal) * normal), 1e-12 * Norm(total_T));
  }
}

// Exact images of two charges in a sphere; the ball answers as a dipole, which far away is all there is.
TEST(SimSteel, BallMatchesASphereInTheFarField) {
  constexpr double kRadius_m = 0.01, kHalf_m = 1e-4;
  const Vec3 centre_m{0.12, 0.05, 0.02};
  const SteelPiece ball({.shape = base::SteelShape::kBall, .position_base_m = centre_m, .radius_m = kRadius_m});
  Charges charges;
  charges.Resize(2);
  const Vec3 axis = Normalized(kMoment_Am2);
  for (std::size_t i = 0; i < 2; ++i) {
    const Vec3 at = kSource_m - centre_m + (i == 0 ? kHalf_m : -kHalf_m) * axis;
    charges.x[i] = at.x;
    charges.y[i] = at.y;
    charges.z[i] = at.z;
    charges.q[i] = (i == 0 ? 0.5 : -0.5) * Norm(kMoment_Am2) / kHalf_m;
  }
  const CoreImages sphere(kRadius_m, 1);
  Charges images;
  images.Resize(sphere.image_count(2));
  sphere.PlaceImages(charges, images);
  for (const Vec3& p : {Vec3{0, 0, 0.02}, Vec3{-0.03, 0.08, 0}, Vec3{0.2, 0.2, 0.1}}) {
    const Vec3 exact_T = FieldOf(images, p - centre_m);
    EXPECT_LT(Norm(SteelPiece::Answer(ball, OfDipole).FieldAt(p) - exact_T), 0.03 * Norm(exact_T));
  }
}

// An ellipsoid of revolution in a uniform field is magnetised evenly: charge M.n on its surface, M = B / (mu0 N).
TEST(SimSteel, BarMatchesAnEllipsoid) {
  constexpr double kHalf_m = 0.4, kRadius_m = 0.02;
  const double factor = 0.00675;  // N of 20:1 [Osborn 1945, table I: .006749]
  const SteelPiece bar({.shape = base::SteelShape::kBar,
                        .position_base_m = {0.1, 0, -0.4},
                        .direction_base = {1, 0, 0},
                        .radius_m = kRadius_m,
                        .half_length_m = kHalf_m});
  const Vec3 uniform_T{4e-5, 0, 0};
  const auto field = [&](const Vec3&) { return uniform_T; };
  for (const Vec3& p : {Vec3{0.1, 0, 0}, Vec3{0.3, 0.1, 0.05}, Vec3{-0.2, -0.1, 0}}) {
    Vec3 surface_T;  // of slices: charge M.n dA = M dy dz, over the ring at t
    constexpr int kSlices = 400, kSpokes = 16;
    for (int i = 0; i < kSlices; ++i) {
      const double t = -1 + 2 * (i + 0.5) / kSlices;
      const double ring_m = kRadius_m * std::sqrt(1 - t * t);
      // d(pi rho^2) over the slice, outwards of +x where the ring narrows.
      const double charge_Am =
          uniform_T.x / (4e-7 * kPi * factor) * kPi * kRadius_m * kRadius_m * 2 * t * (2.0 / kSlices);
      for (int s = 0; s < kSpokes; ++s) {
        const double angle = 2 * kPi * s / kSpokes;
        const Vec3 x{0.1 + kHalf_m * t, ring_m * std::cos(angle), -0.4 + ring_m * std::sin(angle)};
        const Vec3 d = p - x;
        surface_T += (1e-7 * charge_Am / kSpokes / std::pow(Norm(d), 3)) * d;
      }
    }
    EXPECT_LT(Norm(SteelPiece::Answer(bar, field).FieldAt(p) - surface_T), 0.01 * Norm(surface_T));
  }
}

base::TruthEffects WithSteel(std::vector<base::Steel> steel) {
  base::TruthEffects effects;
  effects.room.steel = std::move(steel);
  return effects;
}

const MagnetPose kPose{{0.01, -0.02, 0.06}, Normalized(Vec3{0.2, 0.1, -1})};

SensorFields ReadingsOf(const base::TruthEffects& effects, const MagnetPose* pose, const CoilArray& current_A) {
  Rig rig(support::NominalDevice(), {.sizes = NoImperfections(), .noise = NoiseMode::kNone, .effects = effects});
  return rig.Readings(pose, current_A);
}

// Steel brought into the room changes readings only from then on, and tool and coils each have their image.
TEST(SimSteel, SensorsSeeImagesOfToolAndCoils) {
  const base::Steel desk{.position_base_m = {0, 0, -0.15}};
  const base::TruthEffects with = WithSteel({desk}), none;
  const CoilArray currents{5, -3, 4};
  const auto change = [&](const MagnetPose* pose, const CoilArray& current_A) {
    const SensorFields a = ReadingsOf(with, pose, current_A), b = ReadingsOf(none, pose, current_A);
    std::array<Vec3, base::kSensorCount> change_T;
    for (std::size_t i = 0; i < a.size(); ++i) change_T[i] = a[i] - b[i];
    return change_T;
  };
  const auto of_tool = change(&kPose, {}), of_coils = change(nullptr, currents), of_both = change(&kPose, currents);
  for (std::size_t i = 0; i < of_tool.size(); ++i) {
    EXPECT_GT(Norm(of_tool[i]), 5e-6);
    EXPECT_GT(Norm(of_coils[i]), 1e-6);
    EXPECT_LT(Norm(of_tool[i] + of_coils[i] - of_both[i]), 1e-6 * Norm(of_both[i])) << "answers add up";
  }
  base::Steel later = desk;
  later.from_s = 5;
  Rig rig(support::NominalDevice(),
          {.sizes = NoImperfections(), .noise = NoiseMode::kNone, .effects = WithSteel({later})});
  const SensorFields before = rig.Readings(&kPose, {});
  EXPECT_EQ(before[3], ReadingsOf(none, &kPose, {})[3]);
  rig.SetTime(5);
  EXPECT_EQ(rig.Readings(&kPose, {})[3], ReadingsOf(with, &kPose, {})[3]);
}

// Steel under the base attracts the pen, with about the inverse fourth power of the distance to the mirror image.
TEST(SimSteel, PullsThePen) {
  const auto pull_N = [&](double z_m) {
    const std::vector<base::Steel> steel{{.position_base_m = {0, 0, z_m}}};
    TruthModel model(support::NominalDevice(), {}, false, steel);
    return model.ForcesAt(kPose, 1).core.force_N.z - model.ForcesAt(kPose).core.force_N.z;
  };
  EXPECT_LT(pull_N(-0.1), 0);
  const double ratio = pull_N(-0.1) / pull_N(-0.26);
  EXPECT_NEAR(ratio, std::pow(2, 4), 5);
}

TEST(SimRoom, FieldStepsOccurAtTheirTime) {
  base::TruthEffects effects;
  effects.room.steps = {{{2e-5, 0, 0}, 10, 0}, {{0, 4e-6, 0}, 20, 10}};
  Random random(5);
  const Environment environment(effects, random);
  EXPECT_EQ(environment.At(9.999).background_base_T, Vec3{});
  EXPECT_EQ(environment.At(10).background_base_T, (Vec3{2e-5, 0, 0}));
  EXPECT_NEAR(environment.At(25).background_base_T.y, 2e-6, 1e-18);
  EXPECT_NEAR(environment.At(1e3).background_base_T.y, 4e-6, 1e-18);
}

// The field stays where it is, so that in the base's frame it turns the opposite way; known is what it was at first.
TEST(SimRoom, EarthFieldTurnsOppositeToTheBase) {
  base::TruthEffects effects;
  effects.background_known = false;
  effects.earth_field_base_T = {2e-5, 0, -4.4e-5};
  effects.room.turn_rate_rad_s = kPi / 2;
  effects.room.turn_from_s = 3;
  effects.room.turn_s = 1;
  Random random(5);
  const Environment raw(effects, random);
  const Vec3 after_T{0, -2e-5, -4.4e-5};
  EXPECT_EQ(raw.At(3).background_base_T, effects.earth_field_base_T);
  EXPECT_LT(Norm(raw.At(4).background_base_T - after_T), 1e-18);
  EXPECT_LT(Norm(raw.At(99).background_base_T - after_T), 1e-18) << "it has stopped";
  effects.background_known = true;
  const Environment known(effects, random);
  EXPECT_EQ(known.At(3).background_base_T, Vec3{});
  EXPECT_LT(Norm(known.At(4).background_base_T - (after_T - effects.earth_field_base_T)), 1e-18);
}

TEST(SimRoom, MainsHasConfiguredHarmonicsAndOneDirection) {
  base::TruthEffects effects;
  effects.room.mains_T = 1e-6;
  effects.room.mains_third = 0.3;
  effects.room.mains_fifth = 0.1;
  Random random(5);
  const Environment environment(effects, random);
  std::array<double, 6> amplitude_T{};
  constexpr int kSteps = 1000;
  for (std::size_t order = 0; order < amplitude_T.size(); ++order) {
    Vec3 sine, cosine;
    for (int i = 0; i < kSteps; ++i) {
      const double t_s = 0.02 * i / kSteps;
      const double angle = 2 * kPi * 50 * static_cast<double>(order) * t_s;
      sine += (2 * std::sin(angle) / kSteps) * environment.MainsField(t_s);
      cosine += (2 * std::cos(angle) / kSteps) * environment.MainsField(t_s);
    }
    amplitude_T[order] = std::hypot(Norm(sine), Norm(cosine));
  }
  EXPECT_NEAR(amplitude_T[1], 1e-6, 1e-12);
  EXPECT_NEAR(amplitude_T[3], 3e-7, 1e-12);
  EXPECT_NEAR(amplitude_T[5], 1e-7, 1e-12);
  EXPECT_NEAR(amplitude_T[0] + amplitude_T[2] + amplitude_T[4], 0, 1e-12);
  EXPECT_LT(Norm(Cross(environment.MainsField(0.001), environment.MainsField(0.0137))), 1e-24);
}

// A distant magnet's field is that of its dipole; the core adds what a sphere of iron adds.
TEST(SimRoom, ApproachingMagnetMatchesItsDipoleField) {
  base::TruthEffects effects;
  effects.room.magnets = {{{0, 0, 0.1}, {1, 0, 0}, {0.13, 0, 0}, 2, 4}};
  Rig rig(support::NominalDevice(), {.sizes = NoImperfections(), .noise = NoiseMode::kNone, .effects = effects});
  const auto reading = [&](double t_s) {
    rig.SetTime(t_s);
    return rig.Readings(nullptr, {});
  };
  const auto far = reading(0), halfway = reading(3), near = reading(4), still = reading(9);
  for (std::size_t i = 0; i < far.size(); ++i) {
    const Vec3 at = rig.device().sensors[i].position_base_m;
    const auto plain = [&](double x_m) { return Norm(DipoleField({0, 0, 0.1}, at - Vec3{x_m, 0, 0})); };
    EXPECT_NEAR(Norm(far[i]), plain(1), 0.1 * plain(1));
    EXPECT_NEAR(Norm(halfway[i]), plain(0.565), 0.1 * plain(0.565));
    EXPECT_NEAR(Norm(near[i]), plain(0.13), 0.25 * plain(0.13));
    EXPECT_EQ(near[i], still[i]);
  }
}

// A sampler of one resting pen: registers of the sensors after each tick.
class Sampled {
 public:
  explicit Sampled(const base::TruthEffects& effects, double flicker_T = 0)
      : truth_(Device(), {}, false),
        random_(3),
        sampler_(Device(), effects, Sensor(flicker_T), truth_, first_, 4, 0, random_) {}

  void Tick(double run_s) {
    sampler_.Begin();
    const Surroundings now = sampler_.SurroundingsNow(run_s);
    for (int i = 0; i < TickSampler::kSubSteps; ++i) sampler_.Add(first_, now);
    sampler_.TakeSamples(now, random_);
  }
  HallArray::Registers Read(std::size_t sensor) const { return sampler_.hall().Read(sensor); }

 private:
  static base::DeviceGeometry Device() {
    base::DeviceGeometry device = support::NominalDevice();
    device.sensor_noise_T = {};
    return device;
  }
  static base::SensorParameters Sensor(double flicker_T) {
    base::SensorParameters sensor;
    sensor.flicker_T = flicker_T;
    return sensor;
  }
  TruthModel truth_;
  Random random_;
  const Snapshot first_{kPose, true, {}};
  TickSampler sampler_;
};

base::TruthEffects WithFault(const base::SensorFault& fault) {
  base::TruthEffects effects;
  effects.room.faults = {fault};
  return effects;
}

TEST(SimRoom, SensorFaultsAffectOnlyTheirSensor) {
  using Kind = base::SensorFaultKind;
  const double lsb_T = support::NominalDevice().sensor_lsb_T;
  Sampled good({});
  good.Tick(0);
  const auto right = good.Read(2).counts;
  const auto tick = [](const base::SensorFault& fault, double run_s) {
    Sampled sampled(WithFault(fault));
    sampled.Tick(run_s);
    return sampled;
  };
  const auto before = tick({.kind = Kind::kGain, .sensor = 2, .value = 1.1, .from_s = 5}, 4.9);
  EXPECT_EQ(before.Read(2).counts, right);
  const auto gain = tick({.kind = Kind::kGain, .sensor = 2, .value = 1.1, .from_s = 5}, 5);
  for (std::size_t axis = 0; axis < 3; ++axis) EXPECT_NEAR(gain.Read(2).counts[axis], 1.1 * right[axis], 1);
  EXPECT_EQ(gain.Read(3).counts, good.Read(3).counts);
  const auto huge = tick({.kind = Kind::kHuge, .sensor = 2, .value = 9e-4}, 0);
  for (const auto count : huge.Read(2).counts) EXPECT_NEAR(count * lsb_T, 9e-4, lsb_T);
  const auto swapped = tick({.kind = Kind::kSwapped, .sensor = 2, .other = 6}, 0);
  EXPECT_EQ(swapped.Read(2).counts, good.Read(6).counts);
  EXPECT_EQ(swapped.Read(6).counts, right);
  EXPECT_EQ(swapped.Read(5).counts, good.Read(5).counts);
  const auto stuck = tick({.kind = Kind::kStuck, .sensor = 2}, 0);
  EXPECT_TRUE(stuck.Read(2).fresh);
  EXPECT_EQ(stuck.Read(2).counts, (std::array<std::int16_t, 3>{}));
  const auto stopped = tick({.kind = Kind::kStopped, .sensor = 2}, 0);
  EXPECT_FALSE(stopped.Read(2).fresh);
  EXPECT_TRUE(stopped.Read(3).fresh);
}

// White noise averages away over 2^n samples, 1/f noise almost does not: Allan's deviation is about flat.
TEST(SimRoom, FlickerNoiseHasAFlatAllanDeviation) {
  constexpr double kFlicker_T = 2e-6;
  Sampled sampled({}, kFlicker_T);
  std::vector<double> reading_T;
  const double lsb_T = support::NominalDevice().sensor_lsb_T;
  for (int k = 0; k < 65'536; ++k) {
    sampled.Tick(0);
    for (std::size_t i = 0; i < base::kSensorCount; ++i) reading_T.push_back(sampled.Read(i).counts[0] * lsb_T);
  }
  const auto allan_T = [&](std::size_t window) {
    double sum = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < base::kSensorCount; ++i) {
      std::vector<double> means;
      for (std::size_t at = 0; at + window <= reading_T.size() / base::kSensorCount; at += window) {
        double mean = 0;
        for (std::size_t k = at; k < at + window; ++k) mean += reading_T[k * base::kSensorCount + i];
        means.push_back(mean / static_cast<double>(window));
      }
      for (std::size_t k = 1; k < means.size(); ++k, ++count) sum += 0.5 * std::pow(means[k] - means[k - 1], 2);
    }
    return std::sqrt(sum / static_cast<double>(count));
  };
  for (const std::size_t window : {64U, 512U, 4096U}) {
    EXPECT_GT(allan_T(window), 0.45 * kFlicker_T) << window;
    EXPECT_LT(allan_T(window), 1.1 * kFlicker_T) << window;
  }
}

TEST(SimRoom, WarmSensorsDriftByTheirDrawnCoefficients) {
  ImperfectionSizes sizes = NoImperfections();
  sizes.sensor_offset_T = 1e-6;
  sizes.sensor_offset_T_K = 2e-7;
  sizes.sensor_gain_1_K = 5e-4;
  RigOptions options{.sizes = sizes, .noise = NoiseMode::kNone};
  options.effects.sensor_warming_K = 10;
  options.effects.run_s = 60;
  Rig rig(support::NominalDevice(), options);
  const Vec3 ideal_T = ReadingsOf({}, &kPose, {})[4];
  const SensorError& error = rig.imperfections().sensors[4];
  const SensorFields cold = rig.Readings(&kPose, {});
  EXPECT_LT(Norm(cold[4] - ideal_T - error.offset_T), 1e-15);
  rig.SetTime(60);
  const Vec3 warm_T = rig.Readings(&kPose, {})[4];
  EXPECT_NEAR(warm_T.x, ideal_T.x * (1 + 10 * error.gain_1_K.x) + error.offset_T.x + 10 * error.offset_T_K.x, 1e-15);
  EXPECT_NEAR(warm_T.z, ideal_T.z * (1 + 10 * error.gain_1_K.z) + error.offset_T.z + 10 * error.offset_T_K.z, 1e-15);
  EXPECT_GT(Norm(warm_T - cold[4]), 1e-7);
}

}  // namespace test_sim_room
}  // namespace omni::sim
