// The base's numbers as the control core needs them. Defaults: manifests/device/omni.toml (a test compares).
#pragma once

#include <cstdint>

#include "firmware/wire/messages.h"

namespace omni::firmware {

struct CoilSettings {
  float resistance_20C_ohm;
  float inductance_H;
};

struct Settings {
  CoilSettings coils[wire::kCoils] = {{0.633F, 1.05e-3F}, {0.666F, 1.10e-3F}, {0.697F, 1.15e-3F}};
  float current_max_A = 15;      // largest set-point
  float current_trip_A = 15.5F;  // for 1 ms
  float slew_max_A_s = 10000;    // of the reference; the supply's voltage usually limits before
  float power_max_W = 600;       // of all coils
  float supply_min_V = 10;
  float supply_max_V = 26;          // the bridges withstand 30 V
  float temperature_derate_C = 60;  // currents shrink from here ...
  float temperature_max_C = 70;     // ... and trip here
  float copper_J_K = 44.4F;         // heat model, the second estimate beside the resistance
  float copper_to_body_W_K = 1.048F;
  float body_J_K = 94.2F;
  float body_to_air_W_K = 0.7903F;
  float air_C = 24;
  float resistance_per_K = 0.00393F;
  float field_lsb_T = 5.84453536e-8F;
  std::uint16_t field_full_scale = 27376;
  std::uint16_t firmware_version = 0x0001;
  std::uint32_t capabilities = wire::kCurrentSensors | wire::kArming;
  char serial[16] = "omni";
};

// Settings that the host may read and, in idle, change: never beyond the base's built-in limits.
enum class ConfigStatus : std::uint8_t { kOk, kUnknownId, kOutOfRange };

// The value in force; kUnknownId leaves `value` alone.
ConfigStatus GetConfig(const Settings& settings, std::uint16_t id, float& value) noexcept;

// `built`: the settings as constructed. Limits may only be tightened; coils may differ by their tolerance.
ConfigStatus SetConfig(const Settings& built, std::uint16_t id, float value, Settings& settings) noexcept;

// Finite, positive where required, limits in order.
bool AreValid(const Settings& settings) noexcept;

}  // namespace omni::firmware
