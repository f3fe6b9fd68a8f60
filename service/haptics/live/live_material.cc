#include "service/haptics/live/live_material.h"

#include <algorithm>
#include <cmath>

#include "service/base/material.h"
#include "service/haptics/scene/scene.h"

namespace omni::haptics {
namespace {

using base::MaterialField;

constexpr const MaterialField& kHum = base::MaterialFieldOf("vibration.amplitude");
constexpr const MaterialField& kHumFrequency = base::MaterialFieldOf("vibration.frequency");

// True: it has not arrived yet.
bool Glide(const MaterialField& field, double wanted, double share, Material& material) noexcept {
  const double before = field.Get(material);
  if (!std::isfinite(wanted) || before == wanted) return false;
  const double now = before + share * (wanted - before);
  const bool arrived = std::abs(wanted - now) <= field.settled;
  field.Set(material, arrived ? wanted : now);
  return !arrived;
}

// The hum's phase is that of the clock, so another frequency jumps in phase: it is applied in silence.
double HumTo(const MaterialParameters& wanted, const Material& now) noexcept {
  const bool other = wanted.vibration_frequency_Hz != now.vibration_frequency_Hz;
  return other && std::isfinite(wanted.vibration_frequency_Hz) ? 0 : wanted.vibration_amplitude_N;
}

bool GlideTo(const MaterialParameters& wanted, double share, Material& now) noexcept {
  bool moving = false;
  for (const MaterialField* field : base::kLiveFields) {
    if (field == &kHumFrequency) continue;
    const double value = field == &kHum ? HumTo(wanted, now) : wanted.*field->live;
    moving |= Glide(*field, std::clamp(value, field->minimum, field->maximum), share, now);
  }
  if (now.vibration_amplitude_N == 0 && std::isfinite(wanted.vibration_frequency_Hz)) {
    moving |= wanted.vibration_amplitude_N > 0 && now.vibration_frequency_Hz != wanted.vibration_frequency_Hz;
    now.vibration_frequency_Hz =
        std::clamp(wanted.vibration_frequency_Hz, kHumFrequency.minimum, kHumFrequency.maximum);
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
    moving |= GlideTo(
        named != input.materials.end() ? named->parameters : base::ParametersOf(scene.materials()[live.material]),
        share, live.now);
  }
  return moving;
}

}  // namespace omni::haptics
