#include "service/daemon/feel_row.h"

#include <iterator>

#include "service/haptics/live_material.h"
#include "service/protocol/haptic_scene_range.h"

namespace omni::daemon {
namespace {

using haptics::MaterialFeel;
using protocol::HapticFeel;

struct FeelField {
  double MaterialFeel::*feel;
  double HapticFeel::*row;
};
constexpr FeelField kFeelFields[] = {
    {&MaterialFeel::stiffness_N_m, &HapticFeel::stiffness_N_m},
    {&MaterialFeel::damping_Ns_m, &HapticFeel::damping_Ns_m},
    {&MaterialFeel::static_friction, &HapticFeel::static_friction},
    {&MaterialFeel::dynamic_friction, &HapticFeel::dynamic_friction},
    {&MaterialFeel::viscosity_Ns_m, &HapticFeel::viscosity_Ns_m},
    {&MaterialFeel::texture_amplitude_m, &HapticFeel::texture_amplitude_m},
    {&MaterialFeel::texture_wavelength_m, &HapticFeel::texture_wavelength_m},
    {&MaterialFeel::texture_gain, &HapticFeel::texture_gain},
    {&MaterialFeel::vibration_amplitude_N, &HapticFeel::vibration_amplitude_N},
    {&MaterialFeel::vibration_frequency_Hz, &HapticFeel::vibration_frequency_Hz},
    {&MaterialFeel::pop_through_N, &HapticFeel::pop_through_N},
};
static_assert(sizeof(MaterialFeel) == std::size(kFeelFields) * sizeof(double));
static_assert(sizeof(HapticFeel) == std::size(kFeelFields) * sizeof(double));

}  // namespace

MaterialFeel FeelOf(const HapticFeel& row) {
  MaterialFeel feel;
  for (const FeelField& field : kFeelFields) feel.*field.feel = row.*field.row;
  return feel;
}

HapticFeel FeelRow(const haptics::Material& material) {
  const MaterialFeel feel = haptics::FeelIn(material);
  HapticFeel row;
  for (const FeelField& field : kFeelFields) row.*field.row = feel.*field.feel;
  return protocol::Tamed(row);
}

}  // namespace omni::daemon
