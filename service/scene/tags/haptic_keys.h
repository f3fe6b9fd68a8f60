// Keys of a haptic tag other than the numbers of a material (service/base/material.h): its words, and the numbers of a
// joystick, a vehicle and a checkpoint. Drives parsing and clamping; `scene_keys_page` writes the numbers into
// scenes/schema/OMNI_haptic_material.schema.json and docs/scenes.md, and a test compares.
#pragma once

#include <array>
#include <span>
#include <string_view>

#include "service/base/material.h"
#include "service/haptics/scene/scene_input.h"

namespace omni::scene {

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

// Further keys of a node with "role": "joystick".
inline constexpr auto kJoystickKeys = std::to_array<base::NumberField<haptics::JoystickInput>>({
    {"stiffness", "N/m", 0, 500, base::AccessMember<&haptics::JoystickInput::stiffness_N_m>(), ""},
    {"damping", "N*s/m", 0, 5, base::AccessMember<&haptics::JoystickInput::damping_Ns_m>(), ""},
    {"range", "m", 0.001, 0.05, base::AccessMember<&haptics::JoystickInput::range_m>(), "full deflection"},
    {"deadZone", "m", 0, 0.04, base::AccessMember<&haptics::JoystickInput::dead_zone_m>(), "below `range`"},
    {"detentForce", "N", 0, 0.5, base::AccessMember<&haptics::JoystickInput::detent_force_N>(),
     "how strongly the notches hold"},
    {"radialDetents", "1", 0, 8, base::AccessMember<&haptics::JoystickInput::radial_detents>(),
     "notches between dead zone and range"},
    {"angularDetents", "1", 0, 16, base::AccessMember<&haptics::JoystickInput::angular_detents>(),
     "directions the stick prefers"},
});

// Further keys of a node with "role": "vehicle".
inline constexpr auto kVehicleKeys = std::to_array<base::NumberField<haptics::VehicleInput>>({
    {"radius", "m", 0.0005, 0.05, base::AccessMember<&haptics::VehicleInput::radius_m>(), ""},
    {"wheelbase", "m", 0.0005, 0.1, base::AccessMember<&haptics::VehicleInput::wheelbase_m>(), ""},
    {"speedMax", "m/s", 0.001, 1, base::AccessMember<&haptics::VehicleInput::speed_max_m_s>(), ""},
    {"acceleration", "m/s^2", 0.001, 10, base::AccessMember<&haptics::VehicleInput::acceleration_m_s2>(), ""},
    {"steerMax", "rad", 0.01, 1.2, base::AccessMember<&haptics::VehicleInput::steer_max_rad>(), ""},
    {"hitForce", "N", 0, 2, base::AccessMember<&haptics::VehicleInput::hit_force_N>(), ""},
    {"hitSpeed", "m/s", 0.001, 1, base::AccessMember<&haptics::VehicleInput::hit_speed_m_s>(), ""},
    {"hitDuration", "s", 0.005, 0.2, base::AccessMember<&haptics::VehicleInput::hit_duration_s>(), ""},
    {"hitToBase", "1", 0, 1, base::AccessMember<&haptics::VehicleInput::hit_to_base>(),
     "share of a hit that pushes to the base, not off the wall"},
    {"grip", "g", 0.01, 5, base::AccessMember<&haptics::VehicleInput::grip_g>(), "largest acceleration by the tyres"},
    {"slipStiffnessFront", "1/rad", 0.1, 50, base::AccessMember<&haptics::VehicleInput::slip_stiffness_front_per_rad>(),
     "side force over load, per rad of slip angle"},
    {"slipStiffnessRear", "1/rad", 0.1, 50, base::AccessMember<&haptics::VehicleInput::slip_stiffness_rear_per_rad>(),
     "the same at the rear"},
    {"frontShare", "1", 0.2, 0.8, base::AccessMember<&haptics::VehicleInput::front_share>(),
     "of the weight on the front axle"},
    {"inertia", "1", 0.2, 5, base::AccessMember<&haptics::VehicleInput::inertia>(),
     "squared radius of gyration over the product of the axle distances"},
    {"engineForce", "N", 0, 0.1, base::AccessMember<&haptics::VehicleInput::engine_force_N>(), "hum at full speed"},
    {"engineFrequency", "Hz", 0, 150, base::AccessMember<&haptics::VehicleInput::engine_frequency_Hz>(),
     "at full speed"},
    {"roadForce", "N", 0, 0.1, base::AccessMember<&haptics::VehicleInput::road_force_N>(), "ripple of the road"},
    {"roadWavelength", "m", 0.0001, 0.1, base::AccessMember<&haptics::VehicleInput::road_wavelength_m>(), ""},
    {"startLine", "m", -0.1, 0.1, base::AccessMember<&haptics::VehicleInput::start_line_m>(), "ahead of the start"},
    {"lineWidth", "m", 0.001, 0.2, base::AccessMember<&haptics::VehicleInput::line_width_m>(), "of the start line"},
});

// Further keys of a node with "role": "checkpoint".
inline constexpr auto kCheckpointKeys = std::to_array<base::NumberField<haptics::Checkpoint>>({
    {"width", "m", 0.001, 0.2, base::AccessMember<&haptics::Checkpoint::width_m>(),
     "of the line across the road, crossed along the node's x axis"},
});

}  // namespace omni::scene
