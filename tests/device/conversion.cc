// HELLO and TELEMETRY into seam units; the 64-bit continuation of the wire's sequence.
#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "firmware/wire/messages.h"
#include "service/device/scan_conversion.h"

namespace omni::device {
namespace test_device_conversion {

wire::Hello GoodHello() {
  wire::Hello hello;
  hello.capabilities = wire::kDeviceClockIsHostMonotonic;
  std::memcpy(hello.serial, "A17", 3);
  hello.field_lsb_T = 5e-8F;
  hello.field_full_scale = 27376;
  hello.current_max_A = 15;
  hello.calibration_hash = 9;
  return hello;
}

TEST(DeviceInfo, FromHello) {
  const auto info = InfoFromHello(GoodHello());
  ASSERT_TRUE(info.ok()) << info.error();
  EXPECT_EQ(info->serial, "A17");
  EXPECT_FALSE(info->simulation);
  EXPECT_EQ(info->current_max_A, 15);
  EXPECT_EQ(info->calibration_hash, 9U);
}

TEST(DeviceInfo, SerialsMayFillTheFieldAndAreMadePrintable) {
  wire::Hello hello = GoodHello();
  std::memcpy(hello.serial, "0123456789abcdef", 16);
  EXPECT_EQ(InfoFromHello(hello)->serial, "0123456789abcdef");
  hello.serial[3] = '\n';
  hello.serial[4] = '\x1b';
  EXPECT_EQ(InfoFromHello(hello)->serial, "012??56789abcdef") << "control characters never reach a terminal";
}

TEST(DeviceInfo, RejectsOtherProtocolsAndUnmappedClocks) {
  wire::Hello hello = GoodHello();
  hello.version_min = 2;
  hello.version_max = 3;
  auto info = InfoFromHello(hello);
  ASSERT_FALSE(info.ok());
  EXPECT_NE(info.error().find("versions 2 to 3"), std::string::npos) << info.error();
  hello = GoodHello();
  hello.capabilities = 0;
  info = InfoFromHello(hello);
  ASSERT_FALSE(info.ok());
  EXPECT_NE(info.error().find("CLOCK_MONOTONIC"), std::string::npos) << info.error();
}

TEST(DeviceInfo, AcceptsDeviceClockWhereTheTransportMapsIt) {
  wire::Hello hello = GoodHello();
  EXPECT_TRUE(InfoFromHello(hello)->clock_is_host);
  EXPECT_FALSE(InfoFromHello(hello)->arming);
  hello.capabilities = wire::kArming;
  const auto info = InfoFromHello(hello, Clocks::kAny);
  ASSERT_TRUE(info.ok()) << info.error();
  EXPECT_FALSE(info->clock_is_host);
  EXPECT_TRUE(info->arming);
}

TEST(Scan, FromTelemetry) {
  const auto info = InfoFromHello(GoodHello());
  ASSERT_TRUE(info.ok());
  wire::Telemetry telemetry;
  telemetry.field[7][2] = -20000;
  telemetry.age[3] = 7;
  telemetry.fresh_mask = 0x81;
  telemetry.saturated_mask = 1U << 23;
  for (auto& step : telemetry.current) step[1] = -800;
  telemetry.current[3][1] = -1600;
  telemetry.tick_lead = 321;
  telemetry.temperature[0] = 2450;
  telemetry.supply = 14400;
  telemetry.faults = wire::kFaultHallSensor;
  const base::HallScan scan = ScanFromTelemetry(*info, telemetry, 123456, 70000);
  EXPECT_EQ(scan.t_ns, 123'456'000);
  EXPECT_EQ(scan.sequence, 70000U);
  EXPECT_NEAR(scan.field_sensor_T[7].z, -1e-3, 1e-9);
  EXPECT_EQ(scan.age_ns[3], 140'000);
  EXPECT_EQ(scan.fresh_mask, 0x81U);
  EXPECT_EQ(scan.saturated_mask, 1U << 23);
  EXPECT_NEAR(scan.coil_current_A[1], -1.25, 1e-12) << "mean";
  EXPECT_EQ(scan.has_steps, 1U);
  EXPECT_NEAR(scan.step_current_A[2][1], -1, 1e-12);
  EXPECT_NEAR(scan.step_current_A[3][1], -2, 1e-12);
  EXPECT_EQ(scan.tick_lead_ns, 321'000);
  EXPECT_NEAR(scan.coil_temperature_C[0], 24.5, 1e-12);
  EXPECT_NEAR(scan.supply_V, 18, 1e-12);
  EXPECT_EQ(scan.device_faults, wire::kFaultHallSensor);
}

TEST(Sequence, ContinuesAcrossTheWrapAndCountsGaps) {
  SequenceCounter counter;
  EXPECT_TRUE(counter.Advance(65534));
  EXPECT_TRUE(counter.Advance(65535));
  EXPECT_TRUE(counter.Advance(0));
  EXPECT_EQ(counter.sequence(), 65536U);
  EXPECT_EQ(counter.missed(), 0U);
  EXPECT_TRUE(counter.Advance(10));
  EXPECT_EQ(counter.missed(), 9U);
  EXPECT_FALSE(counter.Advance(10)) << "repeated";
  EXPECT_FALSE(counter.Advance(9)) << "stale";
  EXPECT_EQ(counter.sequence(), 65546U);
}

}  // namespace test_device_conversion
}  // namespace omni::device
