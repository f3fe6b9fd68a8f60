// Haptic material: how a surface feels, SI. Ranges of its numbers and their keys in a scene: material_fields.h.
#pragma once

#include <array>
#include <cstdint>
#include <type_traits>

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

// A surface that is sculpted freely: pressed, taken hold of, pushed in and pulled out.
struct Sculpt {
  bool enabled = false;
  Falloff falloff = Falloff::kSmooth;
  Symmetry symmetry = Symmetry::kNone;
  double radius_m = 0.006;      // geodesic, of what moves
  double snap_m = 0;            // grid of the displacement; 0: none
  double grab_force_N = 0.5;    // press at least this ...
  double dwell_s = 0.2;         // ... for this long to take hold
  double resistance_N_m = 200;  // force per displacement while it is formed
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
  double vibration_amplitude_N = 0;
  double vibration_frequency_Hz = 120;
  double pop_through_N = 0;  // 0: never
  double magnet_max_force_N = 0;
  double magnet_range_m = 0.003;
  double temperature_K = 293.15;  // carried, not rendered
  bool smooth = false;            // force shading: facets are felt as the smooth body they stand for
  // Indices into the scene's textures, -1: none. Factor x texel, by SampleTexture (contact/texture.h).
  std::int32_t stiffness_texture = -1;
  std::int32_t friction_texture = -1;      // of both frictions
  std::int32_t vibrotactile_texture = -1;  // of texture_amplitude_m
  Softness softness;
  Extrude extrude;
  Sculpt sculpt;
};
static_assert(std::is_trivially_copyable_v<Material>);

// What of a material an application may change while it is felt: those of its numbers that material_fields.h calls
// live, in that order. Travels between processes as it is.
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

}  // namespace omni::base
