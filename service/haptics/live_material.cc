#include "service/haptics/live_material.h"
#include "service/haptics/scene.h"

#include <algorithm>
#include <cmath>

namespace omni::haptics {
namespace {

// A feel beside the fields of a material that it stands for, and what no change is felt of.
struct FeelField {
  double MaterialFeel::*wanted;
  double Material::*now;
  double largest;  // what is wanted is taken to 0 ... largest
  double still;    // nearer than this is there
};
constexpr FeelField kGliding[] = {
    {&MaterialFeel::stiffness_N_m, &Material::stiffness_N_m, 2000, 0.01},
    {&MaterialFeel::damping_Ns_m, &Material::damping_Ns_m, 5, 1e-4},
    {&MaterialFeel::static_friction, &Material::static_friction, 2, 1e-5},
    {&MaterialFeel::dynamic_friction, &Material::dynamic_friction, 2, 1e-5},
    {&MaterialFeel::viscosity_Ns_m, &Material::viscosity_Ns_m, 5, 1e-4},
    {&MaterialFeel::texture_amplitude_m, &Material::texture_amplitude_m, 0.002, 1e-8},
    {&MaterialFeel::texture_wavelength_m, &Material::texture_wavelength_m, 0.1, 1e-7},
    {&MaterialFeel::texture_gain, &Material::texture_gain, 10, 1e-4},
    {&MaterialFeel::vibration_amplitude_N, &Material::vibration_amplitude_N, 2, 1e-3},
    {&MaterialFeel::pop_through_N, &Material::pop_through_N, 10, 1e-4},
};

// True: it has not arrived yet.
bool Glide(double wanted, double still, double share, double& now) noexcept {
  if (!std::isfinite(wanted) || now == wanted) return false;
  now += share * (wanted - now);
  if (!(std::abs(wanted - now) <= still)) return true;
  now = wanted;
  return false;
}

// The hum's phase is that of the clock, so another frequency is a leap of phase: it is taken in silence.
double HumTo(const MaterialFeel& wanted, const Material& now) noexcept {
  const bool other = wanted.vibration_frequency_Hz != now.vibration_frequency_Hz;
  return other && std::isfinite(wanted.vibration_frequency_Hz) ? 0 : wanted.vibration_amplitude_N;
}

bool GlideTo(const MaterialFeel& wanted, double share, Material& now) noexcept {
  bool moving = false;
  for (const FeelField& field : kGliding) {
    const bool hum = field.wanted == &MaterialFeel::vibration_amplitude_N;
    const double value = std::clamp(hum ? HumTo(wanted, now) : wanted.*field.wanted, 0.0, field.largest);
    moving |= Glide(value, field.still, share, now.*field.now);
  }
  if (now.vibration_amplitude_N == 0 && std::isfinite(wanted.vibration_frequency_Hz)) {
    moving |= wanted.vibration_amplitude_N > 0 && now.vibration_frequency_Hz != wanted.vibration_frequency_Hz;
    now.vibration_frequency_Hz = std::clamp(wanted.vibration_frequency_Hz, 0.0, 1e3);
  }
  return moving;
}

// Slots that are in use come first.
LiveMaterial* MaterialSlot(const Scene& scene, std::uint32_t material, State& state) noexcept {
  for (LiveMaterial& live : state.materials) {
    if (live.material == material) return &live;
    if (live.material != kNoIndex) continue;
    live.material = material;
    live.now = scene.materials()[material];
    return &live;
  }
  return nullptr;
}

}  // namespace

MaterialFeel FeelIn(const Material& material) noexcept {
  MaterialFeel feel;
  for (const FeelField& field : kGliding) feel.*field.wanted = material.*field.now;
  feel.vibration_frequency_Hz = material.vibration_frequency_Hz;
  return feel;
}

bool ChangeMaterials(const Scene& scene, const Input& input, bool touching, State& state) noexcept {
  const double share = touching ? 1 - std::exp(-input.dt_s / kMaterialGlide_s) : 1;
  for (const MaterialChange& change : input.materials) {
    if (change.material < scene.materials().size()) MaterialSlot(scene, change.material, state);
  }
  bool moving = false;
  for (LiveMaterial& live : state.materials) {
    if (live.material == kNoIndex) break;
    const auto named = std::find_if(input.materials.begin(), input.materials.end(),
                                    [&](const MaterialChange& change) { return change.material == live.material; });
    moving |= GlideTo(named != input.materials.end() ? named->feel : FeelIn(scene.materials()[live.material]), share,
                      live.now);
  }
  return moving;
}

}  // namespace omni::haptics
