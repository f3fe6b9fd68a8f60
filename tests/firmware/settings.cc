// The core's defaults equal the device file, which a micro-controller cannot read.
#include <gtest/gtest.h>

#include <limits>

#include "firmware/core/link/settings.h"
#include "firmware/drivers/lis3mdl_registers.h"
#include "service/config/files/device_file.h"

namespace omni::firmware {
namespace test_firmware_settings {

TEST(FirmwareSettings, DefaultsMatchTheDeviceFile) {
  const auto device = config::LoadDeviceFile(OMNI_SOURCE_DIR "/manifests/device/omni.toml");
  ASSERT_TRUE(device.ok()) << device.error();
  const Settings settings;
  for (std::size_t k = 0; k < wire::kCoils; ++k) {
    EXPECT_EQ(settings.coils[k].resistance_20C_ohm, static_cast<float>(device->coils[k].resistance_20C_ohm)) << k;
    EXPECT_EQ(settings.coils[k].inductance_H, static_cast<float>(device->coils[k].inductance_H)) << k;
  }
  EXPECT_EQ(settings.current_max_A, static_cast<float>(device->current_max_A));
  EXPECT_GE(settings.slew_max_A_s, static_cast<float>(device->current_slew_A_s));  // the host stays below
  EXPECT_EQ(settings.temperature_derate_C, static_cast<float>(device->temperature_derate_C));
  EXPECT_EQ(settings.temperature_max_C, static_cast<float>(device->temperature_max_C));
  EXPECT_GE(static_cast<float>(device->supply_V), settings.supply_min_V);
  EXPECT_LE(static_cast<float>(device->supply_V), settings.supply_max_V);
  EXPECT_EQ(settings.copper_J_K, static_cast<float>(device->heat.copper_J_K));
  EXPECT_EQ(settings.copper_to_body_W_K, static_cast<float>(device->heat.copper_to_body_W_K));
  EXPECT_EQ(settings.body_J_K, static_cast<float>(device->heat.body_J_K));
  EXPECT_EQ(settings.body_to_air_W_K, static_cast<float>(device->heat.body_to_air_W_K));
  EXPECT_EQ(settings.air_C, static_cast<float>(device->heat.air_C));
  EXPECT_EQ(settings.field_lsb_T, static_cast<float>(device->sensor_lsb_T));
  EXPECT_NEAR(settings.field_full_scale, device->sensor_range_T / device->sensor_lsb_T, 1);
  EXPECT_EQ(settings.field_full_scale, drivers::lis3mdl::kFullScaleCounts);
  EXPECT_NEAR(settings.field_lsb_T * drivers::lis3mdl::kCountsPerGauss, 1e-4, 1e-8);
}

TEST(FirmwareSettings, RejectsNonFiniteNegativeAndUnorderedValues) {
  EXPECT_TRUE(AreValid(Settings{}));
  constexpr float kBad[] = {std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), -1};
  float Settings::*const kFields[] = {
      &Settings::current_max_A,     &Settings::current_trip_A,  &Settings::slew_max_A_s,
      &Settings::power_max_W,       &Settings::supply_min_V,    &Settings::supply_max_V,
      &Settings::temperature_max_C, &Settings::copper_J_K,      &Settings::copper_to_body_W_K,
      &Settings::body_J_K,          &Settings::body_to_air_W_K, &Settings::temperature_derate_C,
      &Settings::resistance_per_K,  &Settings::field_lsb_T};
  for (const auto field : kFields) {
    for (const float bad : kBad) {
      Settings settings;
      settings.*field = bad;
      EXPECT_FALSE(AreValid(settings)) << bad;
    }
  }
  Settings settings;
  settings.temperature_derate_C = settings.temperature_max_C;
  EXPECT_FALSE(AreValid(settings));
  settings = Settings{};
  settings.current_trip_A = settings.current_max_A - 1;
  EXPECT_FALSE(AreValid(settings));
}

}  // namespace test_firmware_settings
}  // namespace omni::firmware
