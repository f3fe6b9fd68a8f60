// The numbers of a haptic material with their names and units: one row each, for text and JSON.
#pragma once

#include "service/haptics/material.h"

namespace omni::tools {

struct MaterialNumber {
  const char* name;
  const char* unit;
  double haptics::Material::*field;
};

inline constexpr MaterialNumber kMaterialNumbers[] = {
    {"stiffness", "N/m", &haptics::Material::stiffness_N_m},
    {"damping", "N s/m", &haptics::Material::damping_Ns_m},
    {"static friction", "", &haptics::Material::static_friction},
    {"dynamic friction", "", &haptics::Material::dynamic_friction},
    {"restitution", "", &haptics::Material::restitution},
    {"viscosity", "N s/m", &haptics::Material::viscosity_Ns_m},
    {"texture amplitude", "m", &haptics::Material::texture_amplitude_m},
    {"texture wavelength", "m", &haptics::Material::texture_wavelength_m},
    {"texture gain", "", &haptics::Material::texture_gain},
    {"vibration amplitude", "N", &haptics::Material::vibration_amplitude_N},
    {"vibration frequency", "Hz", &haptics::Material::vibration_frequency_Hz},
    {"pop through", "N", &haptics::Material::pop_through_N},
    {"magnet force", "N", &haptics::Material::magnet_max_force_N},
    {"magnet range", "m", &haptics::Material::magnet_range_m},
    {"temperature", "K", &haptics::Material::temperature_K},
};

struct SoftnessNumber {
  const char* name;
  const char* unit;
  double haptics::Softness::*field;
};

inline constexpr SoftnessNumber kSoftnessNumbers[] = {
    {"young modulus", "Pa", &haptics::Softness::young_modulus_Pa},
    {"poisson ratio", "", &haptics::Softness::poisson_ratio},
    {"thickness", "m", &haptics::Softness::thickness_m},
    {"max depth", "m", &haptics::Softness::max_depth_m},
    {"relaxation time", "s", &haptics::Softness::relaxation_time_s},
};

}  // namespace omni::tools
