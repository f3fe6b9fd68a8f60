#include "service/sim/fields/truth_model.h"
#include "service/sim/fields/vec3.h"

#include <algorithm>
#include <cmath>

namespace omni::sim {
namespace {

// Nodes per face: rings x spokes.
constexpr int kFineRings = 4, kFineSpokes = 12;      // 96 charges
constexpr int kMirrorRings = 3, kMirrorSpokes = 12;  // 72 charges
constexpr int kMediumRings = 4, kMediumSpokes = 10;  // 80 charges
constexpr int kCoarseRings = 3, kCoarseSpokes = 8;   // 48 charges
constexpr int kFarRings = 1, kFarSpokes = 4;         // 8 charges: exact to third order in size over distance
// A data sheet's linearity is the greatest deviation from the best line over 12 of 16 gauss.
constexpr double kLinearShare = 0.75;

base::MagnetGeometry WithStrength(base::MagnetGeometry magnet, double strength) {
  magnet.remanence_T *= strength;
  return magnet;
}

CoilTruth MakeCoil(const base::DeviceGeometry& device, const Imperfections& imperfections, std::size_t k) {
  base::CoilGeometry coil = device.coils[k];
  coil.shell_radius_min_m *= imperfections.coil_size[k];
  coil.shell_radius_max_m *= imperfections.coil_size[k];
  coil.band_half_width_m *= imperfections.coil_size[k];
  const Vec3 axis = Rotated(Normalized(coil.axis_base), imperfections.coil_rotation_rad[k]);
  return CoilTruth(coil, static_cast<int>(k), axis, imperfections.coil_strength[k], device.core_radius_m,
                   device.core_kappa, imperfections.core_offset_base_m);
}

void Accumulate(ForceAndTorque& sum, const Charges& charges, std::size_t i, const Vec3& centre_base_m,
                const Vec3& field_T) noexcept {
  const Vec3 force_N = charges.q[i] * field_T;
  sum.force_N += force_N;
  sum.torque_Nm += Cross(charges.position(i) - centre_base_m, force_N);
}

// The best line through t^3 on [-1, 1] is 3 t / 5, and 2/5 the greatest distance: at t = 1.
double Bent(double reading_T, double share, double range_T) noexcept {
  const double t = reading_T / range_T;
  return reading_T + share * range_T * 2.5 * t * (t * t - 0.6);
}

}  // namespace

Vec3 ForceMap::CoilForce(const CoilArray& current_A) const noexcept {
  Vec3 force_N;
  for (std::size_t k = 0; k < coil.size(); ++k) force_N += current_A[k] * coil[k].force_N;
  return force_N;
}

// Its own image grows with the magnet.
Vec3 ForceMap::Force(const CoilArray& current_A, const Surroundings& surroundings) const noexcept {
  const Vec3& m = surroundings.core_moment_Am2;
  const Vec3 dipole_N = m.x * dipole[0].force_N + m.y * dipole[1].force_N + m.z * dipole[2].force_N;
  const double scale = surroundings.magnet_scale;
  return scale * (CoilForce(current_A) + dipole_N) + (scale * scale) * core.force_N;
}

TruthModel::Sampled::Sampled(const base::MagnetGeometry& magnet, int rings, int spokes) : faces(magnet, rings, spokes) {
  charges.Resize(faces.charge_count());
}

template <class Field>
class TruthModel::SteelAndCore {
 public:
  SteelAndCore(const TruthModel& model, const SteelPiece& piece, const Field& field_T) noexcept
      : SteelAndCore(model, piece, field_T, piece.MeanField(field_T)) {}
  SteelAndCore(const TruthModel& model, const SteelPiece& piece, const Field& field_T, const Vec3& mean_T) noexcept
      : model_(model),
        answer_(piece, field_T, mean_T),
        core_Am2_(model.CoreAnswer_Am2(answer_.FieldAt(model.core_centre_base_m_))) {}
  Vec3 FieldAt(const Vec3& point_base_m) const noexcept {
    return answer_.FieldAt(point_base_m) + model_.CoreField(core_Am2_, point_base_m);
  }

 private:
  const TruthModel& model_;
  SteelPiece::Answer<Field> answer_;
  Vec3 core_Am2_;
};

TruthModel::TruthModel(const base::DeviceGeometry& drawn, const Imperfections& imperfections, bool flip_coil_z,
                       std::span<const base::Steel> steel)
    : TruthModel(Made{TrueSizes(drawn, imperfections)}, imperfections, flip_coil_z, steel) {}

TruthModel::TruthModel(const Made& made, const Imperfections& imperfections, bool flip_coil_z,
                       std::span<const base::Steel> steel)
    : core_radius_m_(made.device.core_radius_m),
      core_kappa_(made.device.core_kappa),
      core_centre_base_m_(imperfections.core_offset_base_m),
      linear_range_T_(kLinearShare * made.device.sensor_range_T),
      core_(made.device.core_radius_m, made.device.core_kappa, imperfections.core_offset_base_m),
      coils_{MakeCoil(made.device, imperfections, 0), MakeCoil(made.device, imperfections, 1),
             MakeCoil(made.device, imperfections, 2)},
      fine_(WithStrength(made.device.magnet, imperfections.magnet_strength), kFineRings, kFineSpokes),
      mirror_(WithStrength(made.device.magnet, imperfections.magnet_strength), kMirrorRings, kMirrorSpokes),
      medium_(WithStrength(made.device.magnet, imperfections.magnet_strength), kMediumRings, kMediumSpokes),
      coarse_(WithStrength(made.device.magnet, imperfections.magnet_strength), kCoarseRings, kCoarseSpokes),
      far_(WithStrength(made.device.magnet, imperfections.magnet_strength), kFarRings, kFarSpokes) {
  if (flip_coil_z) polarity_[2] = -1;
  images_.Resize(core_.image_count(mirror_.charges.size()));
  coarse_images_.Resize(core_.image_count(coarse_.charges.size()));
  far_images_.Resize(core_.image_count(far_.charges.size()));
  medium_fields_T_.Resize(medium_.charges);
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const SensorError& error = imperfections.sensors[i];
    const base::SensorGeometry& nominal = made.device.sensors[i];
    Sensor& sensor = sensors_[i];
    sensor.position_base_m = nominal.position_base_m + error.position_base_m;
    sensor.nonlinearity = error.nonlinearity;
    sensor.offset_T = error.offset_T;
    sensor.offset_T_K = error.offset_T_K;
    sensor.gain_1_K = error.gain_1_K;
    const std::array<double, 3> gain{error.gain.x, error.gain.y, error.gain.z};
    for (std::size_t axis = 0; axis < 3; ++axis) {
      sensor.rows[axis] =
          gain[axis] * Rotated(nominal.orientation_base_sensor, Rotated(kUnits[axis], error.rotation_rad));
    }
    for (std::size_t k = 0; k < coils_.size(); ++k) {
      const Vec3 field_T = polarity_[k] * coils_[k].FieldByTurns(sensor.position_base_m);
      sensor.coil_sensor_T_A[k] = {Dot(sensor.rows[0], field_T), Dot(sensor.rows[1], field_T),
                                   Dot(sensor.rows[2], field_T)};
    }
  }
  for (const base::Steel& one : steel) {
    const SteelPiece& piece = steel_.emplace_back(one);
    auto& at = steel_at_.emplace_back();
    SteelInCoils& in_coils_T_A = steel_in_coils_.emplace_back();
    for (std::size_t k = 0; k < coils_.size(); ++k) {
      const auto of_coil = [&](const Vec3& p) { return polarity_[k] * coils_[k].FieldBySeries(p); };
      in_coils_T_A[k] = piece.MeanField(of_coil);
      const SteelAndCore answer(*this, piece, of_coil, in_coils_T_A[k]);
      for (std::size_t i = 0; i < at.size(); ++i) at[i].coil_base_T_A[k] = answer.FieldAt(sensors_[i].position_base_m);
    }
    for (std::size_t j = 0; j < kUnits.size(); ++j) {
      const auto of_moment = [&](const Vec3& p) { return CoreField(kUnits[j], p); };
      const SteelAndCore answer(*this, piece, of_moment);
      for (std::size_t i = 0; i < at.size(); ++i)
        at[i].core_base_T_Am2[j] = answer.FieldAt(sensors_[i].position_base_m);
      if (piece.IsPlane()) continue;
      const SteelAndCore of_mean(*this, piece, of_moment, kUnits[j]);
      for (std::size_t i = 0; i < at.size(); ++i) at[i].mean_base_T_T[j] = of_mean.FieldAt(sensors_[i].position_base_m);
    }
  }
}

// a^3 kappa 1e7 B.
Vec3 TruthModel::CoreAnswer_Am2(const Vec3& field_T) const noexcept {
  return (core_radius_m_ * core_radius_m_ * core_radius_m_ * core_kappa_ / kMu0Over4Pi) * field_T;
}

Vec3 TruthModel::CoreField(const Vec3& moment_Am2, const Vec3& at_base_m) const noexcept {
  return DipoleField(moment_Am2, at_base_m - core_centre_base_m_);
}

Vec3 TruthModel::OtherMagnets(const Surroundings& surroundings, const Vec3& at_base_m) const noexcept {
  Vec3 field_T;
  for (std::size_t j = 0; j < surroundings.magnet_count; ++j) {
    const Surroundings::Magnet& magnet = surroundings.magnets[j];
    field_T += DipoleField(magnet.moment_Am2, at_base_m - magnet.position_base_m);
    const Vec3 at_core_T = DipoleField(magnet.moment_Am2, core_centre_base_m_ - magnet.position_base_m);
    field_T += CoreField(CoreAnswer_Am2(at_core_T), at_base_m);
  }
  return field_T;
}

// Precondition: the tool is placed if `present`.
Vec3 TruthModel::SteelField(std::size_t index, bool present, const CoilArray& current_A,
                            const Surroundings& surroundings) const noexcept {
  const auto of_tool_and_magnets = [&](const Vec3& p) {
    Vec3 field_T = OtherMagnets(surroundings, p);
    if (present) field_T += surroundings.magnet_scale * (FieldOf(far_.charges, p) + FieldOf(far_images_, p));
    return field_T;
  };
  const Vec3& m = surroundings.core_moment_Am2;
  Vec3 field_T;
  for (std::size_t j = 0; j < steel_.size(); ++j) {
    if (((surroundings.steel_mask >> j) & 1U) == 0) continue;
    const SteelAtSensor& at = steel_at_[j][index];
    const Vec3 mean_T = steel_[j].MeanField(of_tool_and_magnets);
    if (steel_[j].IsPlane()) {
      field_T += SteelAndCore(*this, steel_[j], of_tool_and_magnets, mean_T).FieldAt(sensors_[index].position_base_m);
    } else {
      field_T += mean_T.x * at.mean_base_T_T[0] + mean_T.y * at.mean_base_T_T[1] + mean_T.z * at.mean_base_T_T[2];
    }
    field_T += m.x * at.core_base_T_Am2[0] + m.y * at.core_base_T_Am2[1] + m.z * at.core_base_T_Am2[2];
    for (std::size_t k = 0; k < current_A.size(); ++k) field_T += current_A[k] * at.coil_base_T_A[k];
  }
  return field_T;
}

void TruthModel::PlaceTool(const MagnetPose& pose) noexcept {
  fine_.Place(pose);
  mirror_.Place(pose);
  core_.PlaceImages(mirror_.charges, images_);
  if (!steel_.empty()) PlaceFar(pose);
}

void TruthModel::PlaceFar(const MagnetPose& pose) noexcept {
  far_.Place(pose);
  core_.PlaceImages(far_.charges, far_images_);
}

// Columns of rows (I + dipole field of the core's answer a^3 kappa 1e7 B).
std::array<Vec3, 3> TruthModel::UniformResponse(std::size_t index) const noexcept {
  const Sensor& sensor = sensors_[index];
  std::array<Vec3, 3> columns = kUnits;
  for (Vec3& column : columns) {
    const Vec3 b = column + CoreField(CoreAnswer_Am2(column), sensor.position_base_m);
    column = {Dot(sensor.rows[0], b), Dot(sensor.rows[1], b), Dot(sensor.rows[2], b)};
  }
  return columns;
}

Vec3 TruthModel::Reading(std::size_t index, bool present, const CoilArray& current_A,
                         const Surroundings& surroundings) const noexcept {
  const Sensor& sensor = sensors_[index];
  const Vec3& at = sensor.position_base_m;
  const Vec3 answer_Am2 = CoreAnswer_Am2(surroundings.background_base_T);
  Vec3 field_T = surroundings.background_base_T + CoreField(answer_Am2 + surroundings.core_moment_Am2, at);
  if (surroundings.magnet_count > 0) field_T += OtherMagnets(surroundings, at);
  if (surroundings.steel_mask != 0) field_T += SteelField(index, present, current_A, surroundings);
  if (present) field_T += surroundings.magnet_scale * (FieldOf(fine_.charges, at) + FieldOf(images_, at));
  Vec3 reading_T{Dot(sensor.rows[0], field_T), Dot(sensor.rows[1], field_T), Dot(sensor.rows[2], field_T)};
  for (std::size_t k = 0; k < current_A.size(); ++k) reading_T += current_A[k] * sensor.coil_sensor_T_A[k];
  const Vec3 bent_T{Bent(reading_T.x, sensor.nonlinearity.x, linear_range_T_),
                    Bent(reading_T.y, sensor.nonlinearity.y, linear_range_T_),
                    Bent(reading_T.z, sensor.nonlinearity.z, linear_range_T_)};
  const double warmer_K = surroundings.sensor_warming_K;
  const Vec3 gain{1 + warmer_K * sensor.gain_1_K.x, 1 + warmer_K * sensor.gain_1_K.y, 1 + warmer_K * sensor.gain_1_K.z};
  return Vec3{gain.x * bent_T.x, gain.y * bent_T.y, gain.z * bent_T.z} + sensor.offset_T + warmer_K * sensor.offset_T_K;
}

Vec3 TruthModel::SensorField(std::size_t index, const MagnetPose* pose, const CoilArray& current_A,
                             const Surroundings& surroundings) noexcept {
  if (pose != nullptr) PlaceTool(*pose);
  return Reading(index, pose != nullptr, current_A, surroundings);
}

SensorFields TruthModel::AllSensorFields(const MagnetPose* pose, const CoilArray& current_A,
                                         const Surroundings& surroundings) noexcept {
  if (pose != nullptr) PlaceTool(*pose);
  SensorFields fields;
  for (std::size_t i = 0; i < fields.size(); ++i) fields[i] = Reading(i, pose != nullptr, current_A, surroundings);
  return fields;
}

// m = 1e7 a^3 kappa B(0) of tool and background, and each coil's core share.
Vec3 TruthModel::InducedMoment(const MagnetPose* pose, const CoilArray& current_A,
                               const Surroundings& surroundings) noexcept {
  Vec3 field_T = surroundings.background_base_T;
  if (pose != nullptr) {
    coarse_.Place(*pose);
    field_T += surroundings.magnet_scale * FieldOf(coarse_.charges, core_centre_base_m_);
  }
  Vec3 moment_Am2 = CoreAnswer_Am2(field_T);
  for (std::size_t k = 0; k < coils_.size(); ++k) {
    moment_Am2 += (polarity_[k] * current_A[k] * coils_[k].core_moment_Am2()) * coils_[k].axis_base();
  }
  return moment_Am2;
}

// F = sum q B(p), torque = sum (p - centre) x q B(p). Images follow the magnet, so their field is taken as it stands.
ForceMap TruthModel::ForcesAt(const MagnetPose& pose, std::uint32_t steel_mask) noexcept {
  ForceMap map;
  medium_.Place(pose);
  for (std::size_t k = 0; k < coils_.size(); ++k) {
    coils_[k].FieldsBySeries(medium_.charges, medium_fields_T_);
    for (std::size_t i = 0; i < medium_.charges.size(); ++i) {
      Accumulate(map.coil[k], medium_.charges, i, pose.centre_base_m, polarity_[k] * medium_fields_T_[i]);
    }
  }
  coarse_.Place(pose);
  core_.PlaceImages(coarse_.charges, coarse_images_);
  for (std::size_t i = 0; i < coarse_.charges.size(); ++i) {
    const Vec3 at = coarse_.charges.position(i);
    Accumulate(map.core, coarse_.charges, i, pose.centre_base_m, FieldOf(coarse_images_, at));
    for (std::size_t j = 0; j < kUnits.size(); ++j) {
      Accumulate(map.dipole[j], coarse_.charges, i, pose.centre_base_m, CoreField(kUnits[j], at));
    }
  }
  if (steel_mask == 0) return map;
  PlaceFar(pose);
  for (std::size_t j = 0; j < steel_.size(); ++j) {
    if (((steel_mask >> j) & 1U) != 0) AddSteel(j, pose.centre_base_m, map);
  }
  return map;
}

// Precondition: the far magnet and its images are placed. Coils and tool; the core's extra moment is too weak.
void TruthModel::AddSteel(std::size_t j, const Vec3& centre_base_m, ForceMap& map) const noexcept {
  const auto add = [&](const auto& field_T, const Vec3& mean_T, ForceAndTorque& sum) {
    const SteelAndCore answer(*this, steel_[j], field_T, mean_T);
    for (std::size_t i = 0; i < far_.charges.size(); ++i) {
      Accumulate(sum, far_.charges, i, centre_base_m, answer.FieldAt(far_.charges.position(i)));
    }
  };
  const auto of_tool = [&](const Vec3& p) { return FieldOf(far_.charges, p) + FieldOf(far_images_, p); };
  add(of_tool, steel_[j].MeanField(of_tool), map.core);
  for (std::size_t k = 0; k < coils_.size(); ++k) {
    const auto of_coil = [&](const Vec3& p) { return polarity_[k] * coils_[k].FieldBySeries(p); };
    add(of_coil, steel_in_coils_[j][k], map.coil[k]);
  }
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
