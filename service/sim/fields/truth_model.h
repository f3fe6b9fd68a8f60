// The true fields and forces: what every sensor sees, and what pulls on the pen.
// One model per thread: it keeps scratch space, so that a device tick allocates nothing.
#pragma once

#include <array>
#include <span>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/sim/coils/effects.h"
#include "service/sim/fields/charges.h"
#include "service/sim/fields/core_images.h"
#include "service/sim/fields/imperfections.h"
#include "service/sim/fields/steel.h"
#include "service/sim/fields/winding.h"

namespace omni::sim {

using CoilArray = std::array<double, base::kCoilCount>;

using SensorFields = std::array<Vec3, base::kSensorCount>;

// Force and torque on the pen at its nominal moment: F = sum_k I_k coil[k] + sum_i m_i dipole[i] + core.
struct ForceMap {
  std::array<ForceAndTorque, base::kCoilCount> coil;  // per ampere
  std::array<ForceAndTorque, 3> dipole;               // per A m^2 of the core's extra moment
  ForceAndTorque core;                                // the core's pull on the magnet ("snapping")

  Vec3 CoilForce(const CoilArray& current_A) const noexcept;
  // Of a magnet whose moment has changed by `surroundings.magnet_scale`.
  Vec3 Force(const CoilArray& current_A, const Surroundings& surroundings) const noexcept;
};

class TruthModel {
 public:
  // Steel stands outside the windings and never cuts the pen.
  TruthModel(const base::DeviceGeometry& device, const Imperfections& imperfections, bool flip_coil_z,
             std::span<const base::Steel> steel = {});

  // What sensor `index` would read without noise, in its own frame; `pose` null: no pen in reach.
  Vec3 SensorField(std::size_t index, const MagnetPose* pose, const CoilArray& current_A,
                   const Surroundings& surroundings = {}) noexcept;
  // All sensors at one instant: the magnet is placed once.
  SensorFields AllSensorFields(const MagnetPose* pose, const CoilArray& current_A,
                               const Surroundings& surroundings = {}) noexcept;

  // The core's instantaneous moment, without memory.
  Vec3 InducedMoment(const MagnetPose* pose, const CoilArray& current_A, const Surroundings& surroundings) noexcept;

  // `steel_mask`: as Surroundings. Other magnets pull with a few millinewtons at 0.2 m and are left out.
  ForceMap ForcesAt(const MagnetPose& pose, std::uint32_t steel_mask = 0) noexcept;

  const std::array<CoilTruth, base::kCoilCount>& coils() const noexcept { return coils_; }

  // How a sensor really stands and reads: reading = rows . B(position) + coil_sensor_T_A I, then bent.
  struct Sensor {
    Vec3 position_base_m;
    std::array<Vec3, 3> rows;                            // gain x R_SB
    std::array<Vec3, base::kCoilCount> coil_sensor_T_A;  // of the actual windings, fixed
    Vec3 nonlinearity;                                   // greatest deviation over full scale
    Vec3 offset_T, offset_T_K, gain_1_K;                 // of what is read, with its warming
  };
  const Sensor& sensor(std::size_t index) const noexcept { return sensors_[index]; }
  // What a uniform field of 1 T gives there, core included: columns in the sensor's frame.
  std::array<Vec3, 3> UniformResponse(std::size_t index) const noexcept;

 private:
  struct Made {
    base::DeviceGeometry device;  // sizes as they are
  };
  TruthModel(const Made& made, const Imperfections& imperfections, bool flip_coil_z,
             std::span<const base::Steel> steel);

  // What a piece of steel and the core's answer to it add, fixed parts.
  struct SteelAtSensor {
    std::array<Vec3, base::kCoilCount> coil_base_T_A;
    std::array<Vec3, 3> core_base_T_Am2;  // columns: of the core's own moment
    std::array<Vec3, 3> mean_base_T_T;    // columns: of the mean field in a ball or bar
  };
  using SteelInCoils = std::array<Vec3, base::kCoilCount>;  // mean field in a ball or bar, T/A

  void PlaceTool(const MagnetPose& pose) noexcept;
  void PlaceFar(const MagnetPose& pose) noexcept;  // as steel sees it
  // Of the core to a uniform field.
  Vec3 CoreAnswer_Am2(const Vec3& field_T) const noexcept;
  // Of a moment in the core.
  Vec3 CoreField(const Vec3& moment_Am2, const Vec3& at_base_m) const noexcept;
  // A piece's answer to a field of the base, and the core's to that.
  template <class Field>
  class SteelAndCore;
  Vec3 SteelField(std::size_t index, bool present, const CoilArray& current_A,
                  const Surroundings& surroundings) const noexcept;
  void AddSteel(std::size_t j, const Vec3& centre_base_m, ForceMap& map) const noexcept;
  Vec3 OtherMagnets(const Surroundings& surroundings, const Vec3& at_base_m) const noexcept;
  Vec3 Reading(std::size_t index, bool present, const CoilArray& current_A,
               const Surroundings& surroundings) const noexcept;

  double core_radius_m_;
  double core_kappa_;
  Vec3 core_centre_base_m_;
  double linear_range_T_;
  CoreImages core_;
  std::array<CoilTruth, base::kCoilCount> coils_;
  std::array<double, base::kCoilCount> polarity_{1, 1, 1};
  std::array<Sensor, base::kSensorCount> sensors_;
  std::vector<SteelPiece> steel_;
  std::vector<std::array<SteelAtSensor, base::kSensorCount>> steel_at_;  // by piece
  std::vector<SteelInCoils> steel_in_coils_;                             // by piece
  // As many nodes as it takes to leave out less than 1e-7 of a reading (tests/sim/core_series.cc) and 1e-4 of a
  // force (tests/sim/fields.cc).
  struct Sampled {
    MagnetFaces faces;
    Charges charges;
    Sampled(const base::MagnetGeometry& magnet, int rings, int spokes);
    void Place(const MagnetPose& pose) noexcept { faces.PlaceCharges(pose, charges); }
  };
  Sampled fine_;    // its field at the sensors
  Sampled mirror_;  // what the core answers there
  Charges images_;  // of mirror_
  Sampled medium_;  // force in the coils' field, whose sources lie outside the magnet's reach only by 5 mm
  Sampled coarse_;  // force of the core, all whose images are within 9 mm of the origin
  Charges coarse_images_;
  Sampled far_;  // where steel stands, which is never near
  Charges far_images_;
  FieldArray medium_fields_T_;
};

// Magnet against hull. gap > 0: apart. `normal` points from the hull's centre to the nearest point of the magnet;
// moving the magnet by d along it widens the gap by at least d (the disc is convex).
struct Gap {
  double gap_m = 0;
  Vec3 normal_base{0, 0, 1};
};
Gap GapToHull(const base::MagnetGeometry& magnet, double hull_radius_m, const MagnetPose& pose) noexcept;

}  // namespace omni::sim
