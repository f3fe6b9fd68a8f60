#include "tests/bench/harness/room_conditions.h"

#include <array>
#include <cmath>
#include <numbers>

#include "service/base/in_parallel.h"
#include "service/config/files/calibration_file.h"
#include "service/config/files/device_file.h"
#include "service/config/files/twin_file.h"
#include "service/magnetics/nominal.h"
#include "service/sim/fields/vec3.h"
#include "service/tools/calibrate/calibrate_twin.h"
#include "tests/support/rig/rig.h"

namespace omni::bench {
namespace {

using base::TruthParameters;
using sim::Random;

constexpr double kFirst_s = 5;  // of the first later event
// Until another pen has to be tracked: one of nearly the same moment, and one of another size or material.
constexpr double kNearPen_s = 2, kFarPen_s = 6;

base::Vec3 Direction(Random& draw) {
  const base::Vec3 v = draw.NormalVector(1);
  return (1 / base::Norm(v)) * v;
}

// Ten steps, alternately there and back.
std::vector<double> StepTimes() {
  std::vector<double> times;
  for (int k = 0; k < 10; ++k) times.push_back(kFirst_s * (k + 1));
  return times;
}

Happening AmbientSteps(double size_T) {
  return [size_T](TruthParameters& truth, Random& draw) {
    base::Vec3 step_T;
    for (std::size_t k = 0; k < StepTimes().size(); ++k) {
      step_T = k % 2 == 0 ? size_T * Direction(draw) : -1.0 * step_T;
      truth.effects.room.steps.push_back({.change_base_T = step_T, .at_s = StepTimes()[k]});
    }
  };
}

// A motion to and fro would end where it began; so it keeps turning.
Happening Turning(double rate_deg_s) {
  return [rate_deg_s](TruthParameters& truth, Random&) {
    truth.effects.room.turn_rate_rad_s = rate_deg_s * std::numbers::pi / 180;
    truth.effects.room.turn_from_s = kFirst_s;
    truth.effects.room.turn_s = kRoomRun_s;
  };
}

base::Steel Plane(double z_m, double from_s = 0) {
  return {.shape = base::SteelShape::kPlane, .position_base_m = {0, 0, z_m}, .strength = 1, .from_s = from_s};
}

std::function<void(TruthParameters&)> SteelAt(double z_m) {
  return [z_m](TruthParameters& truth) { truth.effects.room.steel.push_back(Plane(z_m)); };
}

// Laid down within a second, on the desk.
Happening SecondPen(double distance_m) {
  return [distance_m](TruthParameters& truth, Random& draw) {
    const double angle = 2 * std::numbers::pi * draw.Uniform();
    const base::Vec3 away{std::cos(angle), std::sin(angle), 0};
    const base::MagnetGeometry& magnet = config::DefaultDevice().magnet;
    const double moment_Am2 = magnet.remanence_T * magnet.radius_m * magnet.radius_m * 2 * magnet.half_height_m / 4e-7;
    truth.effects.room.magnets.push_back({.moment_Am2 = moment_Am2 * Direction(draw),
                                          .from_base_m = 1.0 * away,
                                          .to_base_m = distance_m * away,
                                          .leaves_s = kFirst_s,
                                          .arrives_s = kFirst_s + 1});
  };
}

// Four magnets, of loudspeakers and lid, on a square of .24 m whose nearest edge comes so near within a second.
Happening Laptop(double distance_m) {
  return [distance_m](TruthParameters& truth, Random& draw) {
    const double angle = 2 * std::numbers::pi * draw.Uniform();
    const base::Vec3 away{std::cos(angle), std::sin(angle), 0}, across{-away.y, away.x, 0};
    for (const double side_m : {-0.12, 0.12}) {
      for (const double further_m : {0.0, 0.24}) {
        const base::Vec3 to_base_m = (distance_m + further_m) * away + side_m * across;
        truth.effects.room.magnets.push_back({.moment_Am2 = 0.5 * Direction(draw),
                                              .from_base_m = to_base_m + 1.0 * away,
                                              .to_base_m = to_base_m,
                                              .leaves_s = kFirst_s,
                                              .arrives_s = kFirst_s + 1});
      }
    }
  };
}

// Comes nearer for ten seconds, from one of five sides.
void Phone(TruthParameters& truth, Random& draw) {
  constexpr std::array<base::Vec3, 5> kSides{{{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0.6, 0, 0.8}}};
  const base::Vec3 side = kSides[static_cast<std::size_t>(draw.Uniform(0, 5))];
  truth.effects.room.magnets.push_back({.moment_Am2 = 0.1 * Direction(draw),
                                        .from_base_m = 0.5 * side,
                                        .to_base_m = 0.13 * side,
                                        .leaves_s = kFirst_s,
                                        .arrives_s = kFirst_s + 10});
}

Happening Faulty(base::SensorFaultKind kind, double value = 0) {
  return [kind, value](TruthParameters& truth, Random& draw) {
    const int sensor = static_cast<int>(draw.Uniform(0, base::kSensorCount));
    truth.effects.room.faults.push_back({.kind = kind,
                                         .sensor = sensor,
                                         .other = (sensor + 1) % base::kSensorCount,
                                         .value = value,
                                         .from_s = kFirst_s});
  };
}

void FiveStop(TruthParameters& truth, Random& draw) {
  const int first = static_cast<int>(draw.Uniform(0, base::kSensorCount));
  for (int k = 0; k < 5; ++k) {
    truth.effects.room.faults.push_back(
        {.kind = base::SensorFaultKind::kStopped, .sensor = (first + k) % base::kSensorCount, .from_s = kFirst_s});
  }
}

// Another pen than the one of the calibration, with so much of its moment: N42 has 11 % less than N52.
Happening Pen(double moment_scale) {
  return [moment_scale](TruthParameters& truth, Random&) {
    truth.effects.room.pens.push_back({.moment_scale = moment_scale});
  };
}

// A hull or core that is wrong by so much, and otherwise nominal.
std::function<void(TruthParameters&)> Wrong(double base::ImperfectionSizes::*size, double value) {
  return [size, value](TruthParameters& truth) {
    truth.imperfections.hull_radius_m = truth.imperfections.core_offset_m = 0;
    truth.imperfections.*size = value;
  };
}

// Offsets come with a warming after the calibration, so that the base is the same one.
void OffsetsPerKelvin(TruthParameters& truth) { truth.imperfections.sensor_offset_T_K = 5e-6; }
void OneKelvin(TruthParameters& truth, Random&) { truth.effects.sensor_warming_K = 1; }

}  // namespace

std::vector<RoomCondition> RoomConditions() {
  using Kind = base::SensorFaultKind;
  using Sizes = base::ImperfectionSizes;
  const std::vector<double> once{kFirst_s};
  return {
      {"room"},
      {"ideal", true},
      {"raw-earth", true, {}, [](TruthParameters& truth, Random&) { truth.effects.background_known = false; }},
      {"as-drawn", false, {}, {}, {}, true},
      {"ambient-5uT", false, {}, AmbientSteps(5e-6), StepTimes()},
      {"ambient-20uT", false, {}, AmbientSteps(20e-6), StepTimes()},
      {"ambient-60uT", false, {}, AmbientSteps(60e-6), StepTimes()},
      {"turning-10", false, {}, Turning(10), once},
      {"turning-90", false, {}, Turning(90), once},
      {"steel-115", false, SteelAt(-0.115), {}},
      {"steel-150", false, SteelAt(-0.150), {}},
      {"steel-200", false, SteelAt(-0.200), {}},
      {"steel-300", false, SteelAt(-0.300), {}},
      {"steel-later",
       false,
       {},
       [](TruthParameters& truth, Random&) { truth.effects.room.steel.push_back(Plane(-0.2, kFirst_s)); },
       once},
      {"second-pen-300", false, {}, SecondPen(0.3), once},
      {"second-pen-200", false, {}, SecondPen(0.2), once},
      {"phone-130", false, {}, Phone, once},
      {"laptop-200", false, {}, Laptop(0.2), once},
      {"gain-1", false, {}, Faulty(Kind::kGain, 1.01), once},
      {"gain-3", false, {}, Faulty(Kind::kGain, 1.03), once},
      {"gain-10", false, {}, Faulty(Kind::kGain, 1.10), once},
      {"stuck", false, {}, Faulty(Kind::kStuck), once},
      {"swapped", false, {}, Faulty(Kind::kSwapped), once},
      {"huge", false, {}, Faulty(Kind::kHuge, 1e-3), once},
      {"dead-5", false, {}, FiveStop, once},
      {"offsets-50mG", false, OffsetsPerKelvin, OneKelvin},
      {"mains-5uT", false, {}, [](TruthParameters& truth, Random&) { truth.effects.room.mains_T = 5e-6; }},
      {"hull-0.3", false, Wrong(&Sizes::hull_radius_m, 3e-4), {}},
      {"core-0.5", false, Wrong(&Sizes::core_offset_m, 2.9e-4), {}},
      {.name = "pen-0.75", .later = Pen(0.75), .settle_s = kFarPen_s},
      {.name = "pen-0.90", .later = Pen(0.90), .settle_s = kNearPen_s},
      {.name = "pen-0.95", .later = Pen(0.95), .settle_s = kNearPen_s},
      {.name = "pen-1.05", .later = Pen(1.05), .settle_s = kNearPen_s},
      {.name = "pen-1.10", .later = Pen(1.10), .settle_s = kNearPen_s},
      {.name = "pen-1.25", .later = Pen(1.25), .settle_s = kFarPen_s},
  };
}

base::DeviceGeometry FastDevice() {
  base::DeviceGeometry device = config::DefaultDevice();
  device.sensor_noise_T = sim::NoiseOf_T(sim::NoiseMode::kLowPower);
  return device;
}

TruthParameters RoomOf(const RoomCondition& condition) {
  TruthParameters truth = condition.ideal ? config::IdealTwin() : config::RoomTwin();
  if (condition.known) condition.known(truth);
  return truth;
}

std::string SurroundingsOf(const RoomCondition& condition) {
  if (condition.as_drawn) return "none";
  if (condition.known) return condition.name;
  return condition.ideal ? "ideal" : "room";
}

base::Result<loop::TickConfig> ConfigIn(const RoomCondition& condition, const base::DeviceGeometry& device,
                                        std::uint64_t seed) {
  if (condition.as_drawn) return loop::MakeTickConfig(device);
  const auto done = tools::CalibrateTwin(device, seed, RoomOf(condition));
  if (!done.ok()) return base::Error{done.error()};
  const std::string text = config::WriteCalibration(tools::CalibrationFileOf(done->outcome, "twin"), device);
  const auto file = config::ParseCalibration(
      text, "room", {.device = device, .drawing = magnetics::NominalCalibration(device), .serial = "twin"});
  if (!file.ok()) return base::Error{file.error()};
  return loop::MakeTickConfig(device, file->calibration);
}

std::optional<base::Error> OnRigs(const RoomCondition& condition, const base::DeviceGeometry& device, std::size_t rigs,
                                  std::uint64_t first_seed,
                                  const std::function<void(std::size_t, std::uint64_t, const loop::TickConfig&)>& use) {
  std::vector<std::string> failed(rigs);
  base::InParallel(rigs, [&](std::size_t r) {
    const auto config = ConfigIn(condition, device, first_seed + r);
    if (config.ok()) {
      use(r, first_seed + r, *config);
    } else {
      failed[r] = config.error();
    }
  });
  for (const std::string& error : failed) {
    if (!error.empty()) return base::Error{error};
  }
  return std::nullopt;
}

}  // namespace omni::bench
