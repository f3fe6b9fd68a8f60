// The one table of every numeric key of a haptic tag: name, unit, range, field. Drives parsing and clamping;
// a test holds scenes/schema/OMNI_haptic_material.schema.json and docs/scenes.md to it.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "service/haptics/scene_input.h"

namespace omni::scene {

template <class T>
struct NumberKey {
  std::string_view key;  // path inside the tag: "softness.thickness"
  std::string_view unit;
  double minimum;
  double maximum;
  double& (*real)(T&);          // the field, or ...
  int& (*whole)(T&) = nullptr;  // ... when it counts something

  double Get(const T& object) const {
    T copy = object;
    return whole ? whole(copy) : real(copy);
  }
  void Set(T& object, double value) const {
    if (whole) {
      whole(object) = static_cast<int>(value);
    } else {
      real(object) = value;
    }
  }
};

// A word of a tag and what it means.
template <class Value>
struct TagWord {
  std::string_view name;
  Value value;
};
inline constexpr std::array kSoftnessModels = {
    TagWord<haptics::SoftnessModel>{"none", haptics::SoftnessModel::kNone},
    TagWord<haptics::SoftnessModel>{"winkler", haptics::SoftnessModel::kWinkler},
    TagWord<haptics::SoftnessModel>{"tet", haptics::SoftnessModel::kTet}};
inline constexpr std::array kFalloffs = {TagWord<haptics::Falloff>{"constant", haptics::Falloff::kConstant},
                                         TagWord<haptics::Falloff>{"linear", haptics::Falloff::kLinear},
                                         TagWord<haptics::Falloff>{"smooth", haptics::Falloff::kSmooth}};
inline constexpr std::array kSymmetries = {TagWord<haptics::Symmetry>{"none", haptics::Symmetry::kNone},
                                           TagWord<haptics::Symmetry>{"x", haptics::Symmetry::kX},
                                           TagWord<haptics::Symmetry>{"y", haptics::Symmetry::kY},
                                           TagWord<haptics::Symmetry>{"z", haptics::Symmetry::kZ}};

// Empty: no such value.
template <class Value, std::size_t kCount>
constexpr std::string_view NameOf(const std::array<TagWord<Value>, kCount>& words, Value value) {
  for (const TagWord<Value>& word : words) {
    if (word.value == value) return word.name;
  }
  return {};
}

// Defaults are those of haptics::Material.
inline constexpr std::array kMaterialKeys = {
    NumberKey<haptics::Material>{"stiffness", "N/m", 0, 2000,
                                 [](haptics::Material& m) -> double& { return m.stiffness_N_m; }},
    NumberKey<haptics::Material>{"damping", "N*s/m", 0, 5,
                                 [](haptics::Material& m) -> double& { return m.damping_Ns_m; }},
    NumberKey<haptics::Material>{"staticFriction", "1", 0, 2,
                                 [](haptics::Material& m) -> double& { return m.static_friction; }},
    NumberKey<haptics::Material>{"dynamicFriction", "1", 0, 2,
                                 [](haptics::Material& m) -> double& { return m.dynamic_friction; }},
    NumberKey<haptics::Material>{"restitution", "1", 0, 1,
                                 [](haptics::Material& m) -> double& { return m.restitution; }},
    NumberKey<haptics::Material>{"viscosity", "N*s/m", 0, 5,
                                 [](haptics::Material& m) -> double& { return m.viscosity_Ns_m; }},
    NumberKey<haptics::Material>{"vibrotactileTexture.amplitude", "m", 0, 0.002,
                                 [](haptics::Material& m) -> double& { return m.texture_amplitude_m; }},
    NumberKey<haptics::Material>{"vibrotactileTexture.wavelength", "m", 0.0001, 0.1,
                                 [](haptics::Material& m) -> double& { return m.texture_wavelength_m; }},
    NumberKey<haptics::Material>{"vibrotactileTexture.gain", "1", 0, 10,
                                 [](haptics::Material& m) -> double& { return m.texture_gain; }},
    NumberKey<haptics::Material>{"vibration.amplitude", "N", 0, 2,
                                 [](haptics::Material& m) -> double& { return m.vibration_amplitude_N; }},
    NumberKey<haptics::Material>{"vibration.frequency", "Hz", 1, 500,
                                 [](haptics::Material& m) -> double& { return m.vibration_frequency_Hz; }},
    NumberKey<haptics::Material>{"softness.youngModulus", "Pa", 1e3, 1e7,
                                 [](haptics::Material& m) -> double& { return m.softness.young_modulus_Pa; }},
    NumberKey<haptics::Material>{"softness.poissonRatio", "1", 0, 0.499,
                                 [](haptics::Material& m) -> double& { return m.softness.poisson_ratio; }},
    NumberKey<haptics::Material>{"softness.thickness", "m", 0.0005, 0.1,
                                 [](haptics::Material& m) -> double& { return m.softness.thickness_m; }},
    NumberKey<haptics::Material>{"softness.maxDepth", "m", 0.0001, 0.05,
                                 [](haptics::Material& m) -> double& { return m.softness.max_depth_m; }},
    NumberKey<haptics::Material>{"softness.relaxationTime", "s", 0.001, 10,
                                 [](haptics::Material& m) -> double& { return m.softness.relaxation_time_s; }},
    NumberKey<haptics::Material>{"softness.fibreRatio", "1", 1, 20,
                                 [](haptics::Material& m) -> double& { return m.softness.fibre_ratio; }},
    NumberKey<haptics::Material>{"softness.hardening", "1", 0, 20,
                                 [](haptics::Material& m) -> double& { return m.softness.hardening; }},
    NumberKey<haptics::Material>{"popThrough", "N", 0, 10,
                                 [](haptics::Material& m) -> double& { return m.pop_through_N; }},
    NumberKey<haptics::Material>{"magnet.maxForce", "N", 0, 2,
                                 [](haptics::Material& m) -> double& { return m.magnet_max_force_N; }},
    NumberKey<haptics::Material>{"magnet.range", "m", 0.0001, 0.03,
                                 [](haptics::Material& m) -> double& { return m.magnet_range_m; }},
    NumberKey<haptics::Material>{"temperature", "K", 200, 400,
                                 [](haptics::Material& m) -> double& { return m.temperature_K; }},
    NumberKey<haptics::Material>{"extrude.step", "m", 0.0005, 0.02,
                                 [](haptics::Material& m) -> double& { return m.extrude.step_m; }},
    NumberKey<haptics::Material>{"extrude.stepsOut", "1", 0, 20, nullptr,
                                 [](haptics::Material& m) -> int& { return m.extrude.steps_out; }},
    NumberKey<haptics::Material>{"extrude.stepsIn", "1", 0, 20, nullptr,
                                 [](haptics::Material& m) -> int& { return m.extrude.steps_in; }},
    NumberKey<haptics::Material>{"extrude.grabForce", "N", 0.05, 2,
                                 [](haptics::Material& m) -> double& { return m.extrude.grab_force_N; }},
    NumberKey<haptics::Material>{"extrude.dwell", "s", 0, 5,
                                 [](haptics::Material& m) -> double& { return m.extrude.dwell_s; }},
    NumberKey<haptics::Material>{"sculptable.radius", "m", 0.0005, 0.03,
                                 [](haptics::Material& m) -> double& { return m.sculpt.radius_m; }},
    NumberKey<haptics::Material>{"sculptable.snap", "m", 0, 0.02,
                                 [](haptics::Material& m) -> double& { return m.sculpt.snap_m; }},
    NumberKey<haptics::Material>{"sculptable.grabForce", "N", 0.05, 2,
                                 [](haptics::Material& m) -> double& { return m.sculpt.grab_force_N; }},
    NumberKey<haptics::Material>{"sculptable.dwell", "s", 0, 5,
                                 [](haptics::Material& m) -> double& { return m.sculpt.dwell_s; }},
    NumberKey<haptics::Material>{"sculptable.resistance", "N/m", 0, 2000,
                                 [](haptics::Material& m) -> double& { return m.sculpt.resistance_N_m; }},
};

// Further keys of a node with "role": "joystick".
inline constexpr std::array kJoystickKeys = {
    NumberKey<haptics::JoystickInput>{"stiffness", "N/m", 0, 500,
                                      [](haptics::JoystickInput& j) -> double& { return j.stiffness_N_m; }},
    NumberKey<haptics::JoystickInput>{"damping", "N*s/m", 0, 5,
                                      [](haptics::JoystickInput& j) -> double& { return j.damping_Ns_m; }},
    NumberKey<haptics::JoystickInput>{"range", "m", 0.001, 0.05,
                                      [](haptics::JoystickInput& j) -> double& { return j.range_m; }},
    NumberKey<haptics::JoystickInput>{"deadZone", "m", 0, 0.04,
                                      [](haptics::JoystickInput& j) -> double& { return j.dead_zone_m; }},
    NumberKey<haptics::JoystickInput>{"detentForce", "N", 0, 0.5,
                                      [](haptics::JoystickInput& j) -> double& { return j.detent_force_N; }},
    NumberKey<haptics::JoystickInput>{"radialDetents", "1", 0, 8, nullptr,
                                      [](haptics::JoystickInput& j) -> int& { return j.radial_detents; }},
    NumberKey<haptics::JoystickInput>{"angularDetents", "1", 0, 16, nullptr,
                                      [](haptics::JoystickInput& j) -> int& { return j.angular_detents; }},
};

// Further keys of a node with "role": "vehicle".
inline constexpr std::array kVehicleKeys = {
    NumberKey<haptics::VehicleInput>{"radius", "m", 0.0005, 0.05,
                                     [](haptics::VehicleInput& v) -> double& { return v.radius_m; }},
    NumberKey<haptics::VehicleInput>{"wheelbase", "m", 0.0005, 0.1,
                                     [](haptics::VehicleInput& v) -> double& { return v.wheelbase_m; }},
    NumberKey<haptics::VehicleInput>{"speedMax", "m/s", 0.001, 1,
                                     [](haptics::VehicleInput& v) -> double& { return v.speed_max_m_s; }},
    NumberKey<haptics::VehicleInput>{"acceleration", "m/s^2", 0.001, 10,
                                     [](haptics::VehicleInput& v) -> double& { return v.acceleration_m_s2; }},
    NumberKey<haptics::VehicleInput>{"steerMax", "rad", 0.01, 1.2,
                                     [](haptics::VehicleInput& v) -> double& { return v.steer_max_rad; }},
    NumberKey<haptics::VehicleInput>{"hitForce", "N", 0, 2,
                                     [](haptics::VehicleInput& v) -> double& { return v.hit_force_N; }},
    NumberKey<haptics::VehicleInput>{"hitSpeed", "m/s", 0.001, 1,
                                     [](haptics::VehicleInput& v) -> double& { return v.hit_speed_m_s; }},
    NumberKey<haptics::VehicleInput>{"hitDuration", "s", 0.005, 0.2,
                                     [](haptics::VehicleInput& v) -> double& { return v.hit_duration_s; }},
    NumberKey<haptics::VehicleInput>{"grip", "g", 0.01, 5,
                                     [](haptics::VehicleInput& v) -> double& { return v.grip_g; }},
    NumberKey<haptics::VehicleInput>{
        "slipStiffnessFront", "1/rad", 0.1, 50,
        [](haptics::VehicleInput& v) -> double& { return v.slip_stiffness_front_per_rad; }},
    NumberKey<haptics::VehicleInput>{"slipStiffnessRear", "1/rad", 0.1, 50,
                                     [](haptics::VehicleInput& v) -> double& { return v.slip_stiffness_rear_per_rad; }},
    NumberKey<haptics::VehicleInput>{"frontShare", "1", 0.2, 0.8,
                                     [](haptics::VehicleInput& v) -> double& { return v.front_share; }},
    NumberKey<haptics::VehicleInput>{"inertia", "1", 0.2, 5,
                                     [](haptics::VehicleInput& v) -> double& { return v.inertia; }},
    NumberKey<haptics::VehicleInput>{"engineForce", "N", 0, 0.1,
                                     [](haptics::VehicleInput& v) -> double& { return v.engine_force_N; }},
    NumberKey<haptics::VehicleInput>{"engineFrequency", "Hz", 0, 150,
                                     [](haptics::VehicleInput& v) -> double& { return v.engine_frequency_Hz; }},
    NumberKey<haptics::VehicleInput>{"roadForce", "N", 0, 0.1,
                                     [](haptics::VehicleInput& v) -> double& { return v.road_force_N; }},
    NumberKey<haptics::VehicleInput>{"roadWavelength", "m", 0.0001, 0.1,
                                     [](haptics::VehicleInput& v) -> double& { return v.road_wavelength_m; }},
    NumberKey<haptics::VehicleInput>{"startLine", "m", -0.1, 0.1,
                                     [](haptics::VehicleInput& v) -> double& { return v.start_line_m; }},
    NumberKey<haptics::VehicleInput>{"lineWidth", "m", 0.001, 0.2,
                                     [](haptics::VehicleInput& v) -> double& { return v.line_width_m; }},
};

// Further keys of a node with "role": "checkpoint".
inline constexpr std::array kCheckpointKeys = {
    NumberKey<haptics::Checkpoint>{"width", "m", 0.001, 0.2,
                                   [](haptics::Checkpoint& c) -> double& { return c.width_m; }},
};

}  // namespace omni::scene
