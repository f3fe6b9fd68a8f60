#include "service/sim/truth_model.h"

#include <algorithm>
#include <cmath>

namespace omni::sim {
namespace {

// Nodes per face: rings x spokes.
constexpr int kFineRings = 6, kFineSpokes = 16;      // 192 charges
constexpr int kMediumRings = 4, kMediumSpokes = 10;  // 80 charges
constexpr int kCoarseRings = 3, kCoarseSpokes = 8;   // 48 charges

base::MagnetGeometry WithStrength(base::MagnetGeometry magnet, double strength) {
  magnet.remanence_T *= strength;
  return magnet;
}

CoilTruth MakeCoil(const base::DeviceGeometry& device, const Imperfections& imperfections, std::size_t k) {
  const base::CoilGeometry& coil = device.coils[k];
  const Vec3 axis = Rotated(Normalised(coil.axis_base), imperfections.coil_rotation_rad[k]);
  return CoilTruth(coil, static_cast<int>(k), axis, imperfections.coil_strength[k], device.core_radius_m,
                   device.core_kappa);
}

void Accumulate(ForceAndTorque& sum, const Charges& charges, std::size_t i, const Vec3& centre_base_m,
                const Vec3& field_T) noexcept {
  const Vec3 force_N = charges.q[i] * field_T;
  sum.force_N += force_N;
  sum.torque_Nm += Cross(charges.position(i) - centre_base_m, force_N);
}

}  // namespace

Vec3 ForceMap::CoilForce(const CoilArray& current_A) const noexcept {
  Vec3 force_N;
  for (std::size_t k = 0; k < coil.size(); ++k) force_N += current_A[k] * coil[k].force_N;
  return force_N;
}

TruthModel::Sampled::Sampled(const base::MagnetGeometry& magnet, int rings, int spokes) : faces(magnet, rings, spokes) {
  charges.Resize(faces.charge_count());
}

TruthModel::TruthModel(const base::DeviceGeometry& device, const Imperfections& imperfections, bool flip_coil_z)
    : core_radius_m_(device.core_radius_m),
      core_kappa_(device.core_kappa),
      coils_{MakeCoil(device, imperfections, 0), MakeCoil(device, imperfections, 1),
             MakeCoil(device, imperfections, 2)},
      fine_(WithStrength(device.magnet, imperfections.magnet_strength), kFineRings, kFineSpokes),
      medium_(WithStrength(device.magnet, imperfections.magnet_strength), kMediumRings, kMediumSpokes),
      coarse_(WithStrength(device.magnet, imperfections.magnet_strength), kCoarseRings, kCoarseSpokes) {
  if (flip_coil_z) polarity_[2] = -1;
  images_.Resize(coarse_.charges.size() + 1);
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const SensorError& error = imperfections.sensors[i];
    const base::SensorGeometry& nominal = device.sensors[i];
    Sensor& sensor = sensors_[i];
    sensor.position_base_m = nominal.position_base_m + error.position_base_m;
    const std::array<Vec3, 3> axes{Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}};
    const std::array<double, 3> gain{error.gain.x, error.gain.y, error.gain.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sensor.rows[axis] =
          gain[axis] * Rotated(Rotated(axes[axis], error.rotation_rad), nominal.orientation_base_sensor);
    }
    for (std::size_t k = 0; k < coils_.size(); ++k) {
      const Vec3 field_T = polarity_[k] * coils_[k].FieldByTurns(sensor.position_base_m);
      sensor.coil_sensor_T_A[k] = {Dot(sensor.rows[0], field_T), Dot(sensor.rows[1], field_T),
                                   Dot(sensor.rows[2], field_T)};
    }
  }
}

Vec3 TruthModel::SensorField(std::size_t index, const MagnetPose* pose, const CoilArray& current_A) noexcept {
  const Sensor& sensor = sensors_[index];
  Vec3 reading_T;
  if (pose != nullptr) {
    fine_.Place(*pose);
    coarse_.Place(*pose);
    PlaceImages(coarse_.charges, core_radius_m_, core_kappa_, images_);
    const Vec3 field_T = FieldOf(fine_.charges, sensor.position_base_m) + FieldOf(images_, sensor.position_base_m);
    reading_T = {Dot(sensor.rows[0], field_T), Dot(sensor.rows[1], field_T), Dot(sensor.rows[2], field_T)};
  }
  for (std::size_t k = 0; k < current_A.size(); ++k) reading_T += current_A[k] * sensor.coil_sensor_T_A[k];
  return reading_T;
}

// F = sum q B(p), torque = sum (p - centre) x q B(p). Images follow the magnet, so their field is taken as it stands.
ForceMap TruthModel::ForcesAt(const MagnetPose& pose) noexcept {
  ForceMap map;
  medium_.Place(pose);
  for (std::size_t i = 0; i < medium_.charges.size(); ++i) {
    for (std::size_t k = 0; k < coils_.size(); ++k) {
      const Vec3 field_T = polarity_[k] * coils_[k].FieldBySeries(medium_.charges.position(i));
      Accumulate(map.coil[k], medium_.charges, i, pose.centre_base_m, field_T);
    }
  }
  coarse_.Place(pose);
  PlaceImages(coarse_.charges, core_radius_m_, core_kappa_, images_);
  for (std::size_t i = 0; i < coarse_.charges.size(); ++i) {
    const Vec3 field_T = FieldOf(images_, coarse_.charges.position(i));
    Accumulate(map.core, coarse_.charges, i, pose.centre_base_m, field_T);
  }
  return map;
}

// In the magnet's own frame the hull's centre is at (rho, z); the nearest point of a cylinder to a point is its clamp.
Gap GapToHull(const base::MagnetGeometry& magnet, double hull_radius_m, const MagnetPose& pose) noexcept {
  const Vec3 to_origin = -pose.centre_base_m;
  const double z = Dot(to_origin, pose.axis_base);
  const Vec3 across = to_origin - z * pose.axis_base;
  const double rho = Norm(across);
  Vec3 nearest = pose.centre_base_m + std::clamp(z, -magnet.half_height_m, magnet.half_height_m) * pose.axis_base;
  if (rho > 0) nearest += (std::min(rho, magnet.radius_m) / rho) * across;
  const double distance = Norm(nearest);
  // The centre inside the magnet: any outward direction frees it; take the magnet's centre, or up.
  if (!(distance > 0)) {
    const double r = Norm(pose.centre_base_m);
    return {-hull_radius_m, r > 0 ? (1 / r) * pose.centre_base_m : Vec3{0, 0, 1}};
  }
  return {distance - hull_radius_m, (1 / distance) * nearest};
}

}  // namespace omni::sim
