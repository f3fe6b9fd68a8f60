// Probing a base: through its interface, and through endpoint 0 while another program holds the interface.
#include <gtest/gtest.h>

#include "service/device/usb/usb_probe.h"
#include "tests/support/chips/fake_usb.h"

namespace omni::device {
namespace test_device_usb_probe {

using test::FakeUsbBus;

constexpr std::int64_t kListen_ns =
    300'000'000;  // on a busy machine the base may run only a few milliseconds in that time

TEST(UsbProbe, ReportsIdentityTelemetryAndKeptFault) {
  FakeUsbBus bus(true);
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.base.keeps_fault = true;
  const auto probe = ProbeUsbBase(bus, entry.listed, {.listen_ns = kListen_ns});
  ASSERT_TRUE(probe.ok()) << probe.error();
  EXPECT_EQ(probe->hello.firmware_version, 0x0102);
  ASSERT_GE(probe->frames, 2U);
  EXPECT_NEAR(static_cast<double>(probe->frames - 1) / probe->listened_s, 1000, 0.1) << "by the base's own clock";
  EXPECT_EQ(probe->missed, 0U);
  EXPECT_EQ(probe->bad_frames, 0U);
  EXPECT_EQ(probe->fresh_sensors, 0xFF);
  ASSERT_TRUE(probe->kept_fault.has_value());
  EXPECT_EQ(probe->kept_fault->fault, wire::kFaultOverTemperature);
  EXPECT_FALSE(probe->armed);
  EXPECT_TRUE(entry.base.arms.empty()) << "probing does not arm";
  EXPECT_TRUE(entry.base.commands.empty());
}

TEST(UsbProbe, ArmsOnRequestWithoutCommandingCurrent) {
  FakeUsbBus bus(true);
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.base.state = wire::State::kFault;
  entry.base.faults = wire::kFaultEmergencyStop;  // latched: allowed here, because the user requests it
  const auto probe = ProbeUsbBase(bus, entry.listed, {.listen_ns = kListen_ns, .arm = true});
  ASSERT_TRUE(probe.ok()) << probe.error();
  EXPECT_TRUE(probe->armed);
  ASSERT_FALSE(entry.base.commands.empty());
  for (const wire::Command& command : entry.base.commands) EXPECT_EQ(command.mode, wire::Mode::kOff);
}

TEST(UsbProbe, ReportsTheFaultThatRefusesArming) {
  FakeUsbBus bus(true);
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.base.refuses_arm = wire::kFaultSupplyLow;
  const auto probe = ProbeUsbBase(bus, entry.listed, {.listen_ns = kListen_ns, .arm = true});
  ASSERT_TRUE(probe.ok()) << probe.error();
  EXPECT_FALSE(probe->armed);
  EXPECT_EQ(probe->refused_by, wire::kFaultSupplyLow);
}

TEST(UsbProbe, ArmsAfterAPendingSelfTest) {
  FakeUsbBus bus(true);
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.base.self_test_ticks = 300;
  const auto probe = ProbeUsbBase(bus, entry.listed, {.listen_ns = kListen_ns, .arm = true});
  ASSERT_TRUE(probe.ok()) << probe.error();
  EXPECT_TRUE(probe->armed);
  EXPECT_GE(entry.base.arms.size(), 3U);
}

TEST(UsbProbe, ErrorsNameTheBase) {
  FakeUsbBus bus(true);
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.base.answers_hello = false;
  const auto mute = ProbeUsbBase(bus, entry.listed, {.listen_ns = kListen_ns});
  ASSERT_FALSE(mute.ok());
  EXPECT_NE(mute.error().find("usb base A17: no HELLO in time"), std::string::npos) << mute.error();
  entry.open_error = "held";
  EXPECT_EQ(ProbeUsbBase(bus, entry.listed, {}).error(), "usb base A17: held");
}

TEST(UsbProbe, EndpointZeroRequestsWorkWithoutClaiming) {
  FakeUsbBus bus;
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.open_error = "another program holds it";
  const auto hello = AskUsbHello(bus, entry.listed);
  ASSERT_TRUE(hello.ok()) << hello.error();
  EXPECT_EQ(hello->current_max_A, 15);
  ASSERT_TRUE(StopUsbBase(bus, entry.listed, 1).ok());
  EXPECT_EQ(entry.base.stops, 1);
  entry.control_error = "gone";
  EXPECT_EQ(StopUsbBase(bus, entry.listed, 1).error(), "usb base A17: gone");
}

}  // namespace test_device_usb_probe
}  // namespace omni::device
