// Haptic material: how a surface feels, SI; and the table of its numbers. From the table follow the keys of a scene's
// tags, their checks, what an application may change at run time and in which range, what `omni scene explain`
// prints, the numbers of scenes/schema/OMNI_haptic_material.schema.json and the table in docs/scenes.md
// (`scene_keys_page` writes both). How to add a number: docs/howto/extend.md.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <type_traits>

#include "service/base/number_field.h"

namespace omni::base {

enum class SoftnessModel : std::uint8_t { kNone = 0, kWinkler = 1, kTet = 2 };

struct Softness {
  SoftnessModel model = SoftnessModel::kNone;
  double young_modulus_Pa = 2.0e4;
  double poisson_ratio = 0.45;
  double thickness_m = 0.01;
  double max_depth_m = 0.008;
  double relaxation_time_s = 0.1;
  double fibre_ratio = 1;                               // Young's modulus along the fibres / across; 1: isotropic
  std::array<double, 3> fibre_direction_base{0, 0, 0};  // of any length; 0: no fibres
  double hardening = 0;                                 // modulus (1 + hardening (depth / thickness)^2)
};

// A region that can be pushed in and pulled out along its mean normal, in whole steps.
struct Extrude {
  bool enabled = false;
  double step_m = 0.004;
  int steps_out = 1;          // furthest step outwards
  int steps_in = 1;           // furthest step inwards
  double grab_force_N = 0.5;  // press at least this ...
  double dwell_s = 0.2;       // ... for this long to take hold of the face
};

enum class Falloff : std::uint8_t { kConstant = 0, kLinear = 1, kSmooth = 2 };
enum class Symmetry : std::uint8_t { kNone = 0, kX = 1, kY = 2, kZ = 3 };  // plane through the object's centre

// A freely sculptable surface: pressed, grabbed, pushed in and pulled out.
struct Sculpt {
  bool enabled = false;
  Falloff falloff = Falloff::kSmooth;
  Symmetry symmetry = Symmetry::kNone;
  double radius_m = 0.006;      // geodesic, of what moves
  double snap_m = 0;            // grid of the displacement; 0: none
  double grab_force_N = 0.5;    // press at least this ...
  double dwell_s = 0.2;         // ... for this long to take hold
  double resistance_N_m = 200;  // force per displacement while it is formed
  double rest_s = 0.5;          // let go of by a tip that rests so long without force; 0: never
};

struct Material {
  double stiffness_N_m = 400;
  double damping_Ns_m = 0;
  double static_friction = 0.5;
  double dynamic_friction = 0.4;  // at most static_friction
  double restitution = 0;
  double viscosity_Ns_m = 0;       // inside the volume
  double texture_amplitude_m = 0;  // vibrotactile texture
  double texture_wavelength_m = 0.001;
  double texture_gain = 1;
  double relief_gain = 0;  // of the heights that the normalTexture stands for; 0: not felt
  double vibration_amplitude_N = 0;
  double vibration_frequency_Hz = 120;
  double pop_through_N = 0;  // 0: never
  double magnet_max_force_N = 0;
  double magnet_range_m = 0.003;
  double temperature_K = 293.15;  // carried, not rendered
  bool smooth = false;            // force shading: facets are rendered as the smooth body that they approximate
  // Indices into the scene's textures, -1: none. Factor x texel, by SampleTexture (contact/effects.h).
  std::int32_t stiffness_texture = -1;
  std::int32_t friction_texture = -1;      // of both frictions
  std::int32_t vibrotactile_texture = -1;  // of texture_amplitude_m
  std::int32_t relief = -1;                // index into the scene's reliefs, -1: none
  Softness softness;
  Extrude extrude;
  Sculpt sculpt;

  void ForgetImages() noexcept {
    stiffness_texture = friction_texture = vibrotactile_texture = relief = -1;
    relief_gain = 0;
  }
};
static_assert(std::is_trivially_copyable_v<Material>);

// Material numbers that an application may change at run time: the live ones of the table below, in its order. Sent
// between processes as is.
struct MaterialParameters {
  double stiffness_N_m = 0;
  double damping_Ns_m = 0;
  double static_friction = 0;
  double dynamic_friction = 0;
  double viscosity_Ns_m = 0;
  double texture_amplitude_m = 0;
  double texture_wavelength_m = 0.001;
  double texture_gain = 0;
  double vibration_amplitude_N = 0;
  double vibration_frequency_Hz = 120;
  double pop_through_N = 0;
};
static_assert(std::is_trivially_copyable_v<MaterialParameters>);

struct MaterialField : NumberField<Material> {
  std::string_view label;                      // for people: "static friction"
  double MaterialParameters::*live = nullptr;  // null: fixed when the scene is loaded
  double settled = 0;                          // of a live one: closer than this to its target counts as reached
};

inline constexpr auto kMaterialFields = std::to_array<MaterialField>({
    {{"stiffness", "N/m", 0, 2000, AccessMember<&Material::stiffness_N_m>(),
      "force per depth; lowered where the loop could not hold it stable"},
     "stiffness",
     &MaterialParameters::stiffness_N_m,
     0.01},
    {{"damping", "N*s/m", 0, 5, AccessMember<&Material::damping_Ns_m>(), "while pressed in"},
     "damping",
     &MaterialParameters::damping_Ns_m,
     1e-4},
    {{"staticFriction", "1", 0, 2, AccessMember<&Material::static_friction>(), "at least `dynamicFriction`"},
     "static friction",
     &MaterialParameters::static_friction,
     1e-5},
    {{"dynamicFriction", "1", 0, 2, AccessMember<&Material::dynamic_friction>(), ""},
     "dynamic friction",
     &MaterialParameters::dynamic_friction,
     1e-5},
    {{"restitution", "1", 0, 1, AccessMember<&Material::restitution>(), ""}, "restitution"},
    {{"viscosity", "N*s/m", 0, 5, AccessMember<&Material::viscosity_Ns_m>(), "inside the volume"},
     "viscosity",
     &MaterialParameters::viscosity_Ns_m,
     1e-4},
    {{"vibrotactileTexture.amplitude", "m", 0, 0.002, AccessMember<&Material::texture_amplitude_m>(),
      "height of a fine grating"},
     "texture amplitude",
     &MaterialParameters::texture_amplitude_m,
     1e-8},
    {{"vibrotactileTexture.wavelength", "m", 0.0001, 0.1, AccessMember<&Material::texture_wavelength_m>(), ""},
     "texture wavelength",
     &MaterialParameters::texture_wavelength_m,
     1e-7},
    {{"vibrotactileTexture.gain", "1", 0, 10, AccessMember<&Material::texture_gain>(), ""},
     "texture gain",
     &MaterialParameters::texture_gain,
     1e-4},
    {{"relief", "1", 0, 4, AccessMember<&Material::relief_gain>(),
      "the glTF material's `normalTexture` is felt, its heights times this; 0: it is not read"},
     "relief"},
    {{"vibration.amplitude", "N", 0, 2, AccessMember<&Material::vibration_amplitude_N>(), "while touched"},
     "vibration amplitude",
     &MaterialParameters::vibration_amplitude_N,
     1e-3},
    {{"vibration.frequency", "Hz", 1, 500, AccessMember<&Material::vibration_frequency_Hz>(), ""},
     "vibration frequency",
     &MaterialParameters::vibration_frequency_Hz,
     1e-3},
    {{"softness.youngModulus", "Pa", 1e3, 1e7, AccessMember<&Material::softness, &Softness::young_modulus_Pa>(),
      "rubber foam 2e4, soft rubber 2e5"},
     "young modulus"},
    {{"softness.poissonRatio", "1", 0, 0.499, AccessMember<&Material::softness, &Softness::poisson_ratio>(), ""},
     "poisson ratio"},
    {{"softness.thickness", "m", 0.0005, 0.1, AccessMember<&Material::softness, &Softness::thickness_m>(),
      "of the soft layer"},
     "thickness"},
    {{"softness.maxDepth", "m", 0.0001, 0.05, AccessMember<&Material::softness, &Softness::max_depth_m>(),
      "where it becomes hard"},
     "max depth"},
    {{"softness.relaxationTime", "s", 0.001, 10, AccessMember<&Material::softness, &Softness::relaxation_time_s>(), ""},
     "relaxation time"},
    {{"softness.fibreRatio", "1", 1, 20, AccessMember<&Material::softness, &Softness::fibre_ratio>(),
      "Young's modulus along the fibres / across"},
     "fibre ratio"},
    {{"softness.hardening", "1", 0, 20, AccessMember<&Material::softness, &Softness::hardening>(),
      "grows with the square of depth / thickness"},
     "hardening"},
    {{"popThrough", "N", 0, 10, AccessMember<&Material::pop_through_N>(), "the tip breaks through above; 0: never"},
     "pop through",
     &MaterialParameters::pop_through_N,
     1e-4},
    {{"magnet.maxForce", "N", 0, 2, AccessMember<&Material::magnet_max_force_N>(), "pull towards the surface"},
     "magnet force"},
    {{"magnet.range", "m", 0.0001, 0.03, AccessMember<&Material::magnet_range_m>(), ""}, "magnet range"},
    {{"temperature", "K", 200, 400, AccessMember<&Material::temperature_K>(), "carried, not rendered"}, "temperature"},
    {{"extrude.step", "m", 0.0005, 0.02, AccessMember<&Material::extrude, &Extrude::step_m>(),
      "a connected region of this material moves along its normal in such steps"},
     "step"},
    {{"extrude.stepsOut", "1", 0, 20, AccessMember<&Material::extrude, &Extrude::steps_out>(),
      "furthest step outwards"},
     "steps out"},
    {{"extrude.stepsIn", "1", 0, 20, AccessMember<&Material::extrude, &Extrude::steps_in>(), "furthest step inwards"},
     "steps in"},
    {{"extrude.grabForce", "N", 0.05, 2, AccessMember<&Material::extrude, &Extrude::grab_force_N>(),
      "press at least this ..."},
     "grab force"},
    {{"extrude.dwell", "s", 0, 5, AccessMember<&Material::extrude, &Extrude::dwell_s>(),
      "... for this long to take hold; then a deeper press moves it in, a pull moves it out"},
     "dwell"},
    {{"sculptable.radius", "m", 0.0005, 0.03, AccessMember<&Material::sculpt, &Sculpt::radius_m>(),
      "the surface is formed by hand; this much of it moves, measured along it"},
     "radius"},
    {{"sculptable.snap", "m", 0, 0.02, AccessMember<&Material::sculpt, &Sculpt::snap_m>(),
      "grid of the displacement; 0: none"},
     "snap"},
    {{"sculptable.grabForce", "N", 0.05, 2, AccessMember<&Material::sculpt, &Sculpt::grab_force_N>(),
      "press at least this ..."},
     "grab force"},
    {{"sculptable.dwell", "s", 0, 5, AccessMember<&Material::sculpt, &Sculpt::dwell_s>(),
      "... for this long to take hold"},
     "dwell"},
    {{"sculptable.resistance", "N/m", 0, 2000, AccessMember<&Material::sculpt, &Sculpt::resistance_N_m>(),
      "force per displacement while it is formed"},
     "resistance"},
    {{"sculptable.rest", "s", 0, 60, AccessMember<&Material::sculpt, &Sculpt::rest_s>(),
      "the tip lets go when it rests so long and neither presses nor pulls; 0: never"},
     "rest"},
});

// The row of a key. Precondition: there is one; where the key is a constant, the compiler refuses any other.
constexpr const MaterialField& MaterialFieldOf(std::string_view key) {
  return kMaterialFields[IndexOfKey(kMaterialFields, key)];
}

// Optional part of a material: a structure of its own, whose numbers are adjacent in the table. Empty: none.
constexpr std::string_view PartOf(const MaterialField& field) {
  const std::string_view group = field.Group();
  return group == "softness" || group == "extrude" || group == "sculptable" ? group : std::string_view();
}

// Each number of the structures has a row; their other members are counted here.
consteval std::size_t RowsOf(std::string_view part) {
  return static_cast<std::size_t>(std::count_if(kMaterialFields.begin(), kMaterialFields.end(),
                                                [part](const auto& field) { return PartOf(field) == part; }));
}
static_assert(FieldCount<Material>() == RowsOf("") + 8, "smooth, three textures, relief, three parts");
static_assert(FieldCount<Softness>() == RowsOf("softness") + 2, "model, fibre_direction_base");
static_assert(FieldCount<Extrude>() == RowsOf("extrude") + 1, "enabled");
static_assert(FieldCount<Sculpt>() == RowsOf("sculptable") + 3, "enabled, falloff, symmetry");

inline constexpr std::size_t kLiveMaterialFields = static_cast<std::size_t>(
    std::count_if(kMaterialFields.begin(), kMaterialFields.end(), [](const auto& f) { return f.live != nullptr; }));
static_assert(sizeof(MaterialParameters) == kLiveMaterialFields * sizeof(double),
              "each member of MaterialParameters is the live one of a row, and of one only");

// The live ones, in their order.
inline constexpr auto kLiveFields = [] {
  std::array<const MaterialField*, kLiveMaterialFields> live{};
  std::size_t n = 0;
  for (const MaterialField& field : kMaterialFields) {
    if (field.live != nullptr) live[n++] = &field;
  }
  return live;
}();

inline MaterialParameters ParametersOf(const Material& material) noexcept {
  MaterialParameters parameters;
  for (const MaterialField* field : kLiveFields) parameters.*field->live = field->Get(material);
  return parameters;
}

// The same with every value clamped to its range; NaN becomes the minimum.
inline MaterialParameters Clamped(const MaterialParameters& parameters) noexcept {
  MaterialParameters clamped;
  for (const MaterialField* field : kLiveFields) {
    const double value = parameters.*field->live;
    clamped.*field->live = std::isnan(value) ? field->minimum : std::clamp(value, field->minimum, field->maximum);
  }
  return clamped;
}

// The first of kLiveFields whose value is out of range; kLiveMaterialFields: none.
inline std::size_t FieldOutOfRange(const MaterialParameters& parameters) noexcept {
  const auto out = std::find_if(kLiveFields.begin(), kLiveFields.end(),
                                [&](const MaterialField* field) { return !field->Contains(parameters.*field->live); });
  return static_cast<std::size_t>(out - kLiveFields.begin());
}

}  // namespace omni::base
