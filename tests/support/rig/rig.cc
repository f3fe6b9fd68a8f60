#include "tests/support/rig/rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "firmware/wire/messages.h"

namespace omni::sim {
namespace {

constexpr double kExactError_m = 1e-6;  // practically none; 0 would mean unknown
constexpr double kAtRest_s = 1e3;       // since the last scan: eddy currents are gone

Imperfections Draw(const RigOptions& options) {
  Random random(options.seed);
  return DrawImperfections(options.sizes, random);
}

Environment DrawEnvironment(const RigOptions& options) {
  Random random(~options.seed);
  return Environment(options.effects, random);
}

Vec3 DrawDirection(double z_min, double z_max, Random& random) noexcept {
  const double z = random.Uniform(z_min, z_max);
  const double angle = random.Uniform(0, 2 * std::numbers::pi);
  const double rho = std::sqrt(1 - z * z);
  return {rho * std::cos(angle), rho * std::sin(angle), z};
}

}  // namespace

std::array<double, 3> NoiseOf_T(NoiseMode mode, const base::SensorParameters& sensor) noexcept {
  switch (mode) {
    case NoiseMode::kUltraHigh:
      return sensor.noise_uhp_T;
    case NoiseMode::kLowPower:
      return sensor.noise_lp_T;
    case NoiseMode::kNone:
      break;
  }
  return {};
}

RigOptions OptionsOf(std::uint64_t seed, NoiseMode noise, const base::TruthParameters& truth) {
  return {.seed = seed, .sizes = truth.imperfections, .noise = noise, .effects = truth.effects, .sensor = truth.sensor};
}

Rig::Rig(const base::DeviceGeometry& device, const RigOptions& options)
    : device_(device),
      options_(options),
      imperfections_(Draw(options)),
      environment_(DrawEnvironment(options)),
      surroundings_(environment_.At(0)),
      memory_(options.effects, device.core_radius_m),
      truth_(device, imperfections_, false, options.effects.room.steel) {
  device_.sensor_noise_T = NoiseOf_T(options.noise, options.sensor);
}

base::Calibration Rig::ExactCalibration() const {
  base::Calibration exact;
  exact.device = device_.name;
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    const TruthModel::Sensor& sensor = truth_.sensor(i);
    base::SensorCalibration known;
    known.position_base_m = sensor.position_base_m;
    for (std::size_t row = 0; row < 3; ++row) {
      const Vec3& gain = sensor.rows[row];
      known.gain_sensor_base[3 * row] = gain.x;
      known.gain_sensor_base[3 * row + 1] = gain.y;
      known.gain_sensor_base[3 * row + 2] = gain.z;
      for (std::size_t k = 0; k < base::kCoilCount; ++k) {
        const Vec3& field = sensor.coil_sensor_T_A[k];
        known.current_map_T_A[3 * row + k] = row == 0 ? field.x : row == 1 ? field.y : field.z;
      }
    }
    const std::array<Vec3, 3> uniform = truth_.UniformResponse(i);
    const Vec3& background_T = environment_.At(0).background_base_T;
    known.background_sensor_T = background_T.x * uniform[0] + background_T.y * uniform[1] + background_T.z * uniform[2];
    exact.sensors.push_back(known);
  }
  exact.sensor_noise_T = device_.sensor_noise_T;
  exact.sensor_range_T = device_.sensor_range_T;
  exact.magnet = device_.magnet;
  const base::DeviceGeometry made = TrueSizes(device_, imperfections_);
  exact.magnet.tip_offset_m = made.magnet.tip_offset_m;
  const double R = device_.magnet.radius_m;
  exact.moment_Am2 = imperfections_.magnet_strength * device_.magnet.remanence_T * std::numbers::pi * R * R * 2 *
                     device_.magnet.half_height_m / (4e-7 * std::numbers::pi);
  exact.core_radius_m = device_.core_radius_m;
  exact.core_kappa = device_.core_kappa;
  exact.core_centre_base_m = imperfections_.core_offset_base_m;
  exact.hull_radius_m = made.hull_radius_m;
  exact.expected_error_m = kExactError_m;
  return exact;
}

MagnetPose Rig::DrawPose(const PoseRange& range, Random& random) const noexcept {
  MagnetPose pose;
  const double radius_m = random.Uniform(range.radius_min_m, range.radius_max_m);  // kept: near the hull few tilts fit
  do {
    const Vec3 outwards = DrawDirection(std::sin(range.elevation_min_rad), 1, random);
    pose.centre_base_m = radius_m * outwards;
    // Uniform on the cap of directions within the tilt of -outwards.
    const double c = random.Uniform(std::cos(range.tilt_max_rad), 1);
    const double angle = random.Uniform(0, 2 * std::numbers::pi);
    const Vec3 across = Perpendicular(outwards);
    const Vec3 other = Cross(outwards, across);
    const double s = std::sqrt(std::max(0.0, 1 - c * c));
    pose.axis_base = Normalized(-c * outwards + s * std::cos(angle) * across + s * std::sin(angle) * other);
  } while (!(GapToHull(device_.magnet, device_.hull_radius_m, pose).gap_m >= 0));
  return pose;
}

SensorFields Rig::Readings(const MagnetPose* pose, const CoilArray& current_A) noexcept {
  return truth_.AllSensorFields(pose, current_A, surroundings_);
}

CoilArray Rig::CurrentsAtRest_A() const noexcept {
  CoilArray read_A{};
  for (std::size_t k = 0; k < read_A.size(); ++k) {
    read_A[k] = wire::kCurrentUnit_A * std::round(imperfections_.current_offset_A[k] / wire::kCurrentUnit_A);
  }
  return read_A;
}

base::HallScan Rig::Scan(const MagnetPose* pose, const CoilArray& current_A, Random& random) noexcept {
  base::HallScan scan;
  scan.sequence = ++sequence_;
  scan.t_ns = static_cast<std::int64_t>(sequence_) * base::kTickPeriod_ns;
  scan.fresh_mask = (1U << base::kSensorCount) - 1;
  scan.supply_V = device_.supply_V;
  Surroundings now = surroundings_;
  const Vec3 induced_Am2 = truth_.InducedMoment(pose, current_A, now);
  if (!remembers_) memory_.Start(induced_Am2);
  remembers_ = true;
  memory_.Step(induced_Am2, kAtRest_s);
  now.core_moment_Am2 = memory_.moment_Am2();
  const SensorFields readings = truth_.AllSensorFields(pose, current_A, now);
  const double full_scale_T = device_.sensor_range_T;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const auto& noise_T = device_.sensor_noise_T;
    std::array<double, 3> field{readings[i].x + noise_T[0] * random.Normal(),
                                readings[i].y + noise_T[1] * random.Normal(),
                                readings[i].z + noise_T[2] * random.Normal()};
    for (std::size_t axis = 0; options_.saturation && axis < 3; ++axis) {
      if (!(std::abs(field[axis]) < full_scale_T)) scan.saturated_mask |= 1U << (3 * i + axis);
      const double counts = std::round(std::clamp(field[axis], -full_scale_T, full_scale_T) / device_.sensor_lsb_T);
      field[axis] = counts * device_.sensor_lsb_T;
    }
    scan.field_sensor_T[i] = {field[0], field[1], field[2]};
  }
  for (std::size_t k = 0; k < base::kCoilCount; ++k) {
    scan.coil_current_A[k] =
        current_A[k] == 0 ? 0 : imperfections_.current_gain[k] * current_A[k] + imperfections_.current_offset_A[k];
    scan.coil_temperature_C[k] = 24;
  }
  return scan;
}

}  // namespace omni::sim
