#include "firmware/core/link/settings.h"

#include "firmware/core/numbers.h"

namespace omni::firmware {
namespace {

constexpr float kDerateSpan_K = 2;            // at least, between derating and tripping
constexpr float kTemperatureMin_C = 30;       // with a lower limit a base would never arm in summer
constexpr float kResistanceTolerance = 0.3F;  // wire length and gauge
constexpr float kInductanceTolerance = 0.5F;

struct Entry {
  wire::ConfigId id;
  float Settings::*field;
  float share_min;  // of the base's built-in value
  float share_max;
};

constexpr Entry kEntries[] = {
    {wire::ConfigId::kCurrentMax_A, &Settings::current_max_A, 0.01F, 1},
    {wire::ConfigId::kSlewMax_A_s, &Settings::slew_max_A_s, 0.01F, 1},
    {wire::ConfigId::kPowerMax_W, &Settings::power_max_W, 0.01F, 1},
    {wire::ConfigId::kTemperatureDerate_C, &Settings::temperature_derate_C, 0, 1},
    {wire::ConfigId::kTemperatureMax_C, &Settings::temperature_max_C, 0, 1},
};

struct CoilEntry {
  wire::ConfigId id;
  float CoilSettings::*field;
  float tolerance;
};

constexpr CoilEntry kCoilEntries[] = {
    {wire::ConfigId::kResistance20_ohm, &CoilSettings::resistance_20C_ohm, kResistanceTolerance},
    {wire::ConfigId::kInductance_H, &CoilSettings::inductance_H, kInductanceTolerance},
};

struct Place {
  float* value = nullptr;
  float low = 0;
  float high = 0;
};

// The field of `settings` for an id, and its range by `built`.
Place Find(const Settings& built, std::uint16_t id, Settings& settings) noexcept {
  for (const Entry& entry : kEntries) {
    if (id != static_cast<std::uint16_t>(entry.id)) continue;
    const float whole = built.*entry.field;
    return {&(settings.*entry.field), entry.share_min * whole, entry.share_max * whole};
  }
  for (const CoilEntry& entry : kCoilEntries) {
    const int coil = id - static_cast<int>(entry.id);
    if (coil < 0 || coil >= wire::kCoils) continue;
    const float whole = built.coils[coil].*entry.field;
    return {&(settings.coils[coil].*entry.field), (1 - entry.tolerance) * whole, (1 + entry.tolerance) * whole};
  }
  return {};
}

bool IsPositive(float value) noexcept { return IsFinite(value) && value > 0; }

}  // namespace

ConfigStatus GetConfig(const Settings& settings, std::uint16_t id, float& value) noexcept {
  Settings copy = settings;
  const Place place = Find(settings, id, copy);
  if (place.value == nullptr) return ConfigStatus::kUnknownId;
  value = *place.value;
  return ConfigStatus::kOk;
}

ConfigStatus SetConfig(const Settings& built, std::uint16_t id, float value, Settings& settings) noexcept {
  Settings changed = settings;
  const Place place = Find(built, id, changed);
  if (place.value == nullptr) return ConfigStatus::kUnknownId;
  if (!(value >= place.low && value <= place.high)) return ConfigStatus::kOutOfRange;
  *place.value = value;
  if (!AreValid(changed)) return ConfigStatus::kOutOfRange;
  settings = changed;
  return ConfigStatus::kOk;
}

bool AreValid(const Settings& settings) noexcept {
  for (const CoilSettings& coil : settings.coils) {
    if (!IsPositive(coil.resistance_20C_ohm) || !IsPositive(coil.inductance_H)) return false;
  }
  const float positive[] = {settings.current_max_A, settings.slew_max_A_s,     settings.power_max_W,
                            settings.supply_min_V,  settings.copper_J_K,       settings.copper_to_body_W_K,
                            settings.body_J_K,      settings.resistance_per_K, settings.body_to_air_W_K,
                            settings.field_lsb_T};
  for (const float value : positive) {
    if (!IsPositive(value)) return false;
  }
  return settings.field_full_scale > 0 && IsFinite(settings.air_C) && IsFinite(settings.current_trip_A) &&
         settings.current_trip_A >= settings.current_max_A && IsFinite(settings.supply_max_V) &&
         settings.supply_max_V > settings.supply_min_V && settings.temperature_derate_C >= kTemperatureMin_C &&
         IsFinite(settings.temperature_max_C) &&
         settings.temperature_max_C >= settings.temperature_derate_C + kDerateSpan_K;
}

}  // namespace omni::firmware
