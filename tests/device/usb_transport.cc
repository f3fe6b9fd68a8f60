// MakeUsbTransport on a fake bus: selecting a base, refusals and their messages, losing a base and reopening it.
#include <gtest/gtest.h>

#include "service/device/usb/usb_transport.h"
#include "tests/support/alloc_probe.h"
#include "tests/support/chips/fake_usb.h"

namespace omni::device {
namespace test_device_usb_transport {

using test::FakeUsbBus;

constexpr std::int64_t kShort_ns = 3'000'000;
constexpr std::int64_t kPatience_ns = 5'000'000'000;

void ExpectRefused(FakeUsbBus& bus, const std::string& serial, std::initializer_list<const char*> parts) {
  const auto transport = MakeUsbTransport(bus, serial, kShort_ns);
  ASSERT_FALSE(transport.ok());
  for (const char* part : parts) {
    EXPECT_NE(transport.error().find(part), std::string::npos) << part << " not in: " << transport.error();
  }
}

TEST(UsbTransport, InfoComesFromHelloAndBus) {
  FakeUsbBus bus;
  bus.Add("A17", "1-2.3");
  const auto transport = MakeUsbTransport(bus, "");
  ASSERT_TRUE(transport.ok()) << transport.error();
  EXPECT_EQ((*transport)->info().name, "usb 1-2.3");
  EXPECT_EQ((*transport)->info().serial, "A17");
  EXPECT_FALSE((*transport)->info().simulation);
  EXPECT_FALSE((*transport)->info().virtual_time);
}

TEST(UsbTransport, ArmsTheBaseAndDeliversCommands) {
  FakeUsbBus bus;
  test::FakeBase& base = bus.Add("A17").base;
  {
    const auto transport = MakeUsbTransport(bus, "A17");
    ASSERT_TRUE(transport.ok()) << transport.error();
    for (int i = 0; i < 20; ++i) {
      bus.link->Step();
      base::HallScan scan;
      ASSERT_EQ((*transport)->Read(scan, 0), ReadStatus::kScan);
      ASSERT_TRUE((*transport)->Write({{0, 0, 2}}));
      bus.link->Pump();
    }
    EXPECT_EQ((*transport)->state().state, static_cast<std::uint8_t>(wire::State::kArmed));
    EXPECT_EQ((*transport)->state().faults, 0U);
    EXPECT_EQ((*transport)->counters().received, 20U);
    EXPECT_EQ((*transport)->counters().sent, 20U);
  }
  EXPECT_EQ(base.commands.back().set_point_A[2], 2);
}

TEST(UsbTransport, SelectsBetweenTwoBasesBySerial) {
  FakeUsbBus bus;
  bus.Add("A17", "1-1");
  bus.Add("B2", "1-2");
  ExpectRefused(bus, "", {"A17", "B2", "--device usb:SERIAL"});
  const auto transport = MakeUsbTransport(bus, "B2");
  ASSERT_TRUE(transport.ok()) << transport.error();
  EXPECT_EQ((*transport)->info().serial, "B2");
}

TEST(UsbTransport, ErrorsNameCauseAndRemedy) {
  FakeUsbBus bus;
  ExpectRefused(bus, "", {"no Omni base on USB"});
  FakeUsbBus::Entry& entry = bus.Add("A17");
  entry.listed.problem = UsbPermissionHelp(entry.listed.node);
  ExpectRefused(bus, "", {"usb base A17", "70-omni.rules", "udevadm"});
  entry.listed.problem.clear();
  entry.open_error = "another program holds it: omnid (pid 5)";
  ExpectRefused(bus, "", {"usb base A17", "omnid (pid 5)"});
  entry.open_error.clear();
  entry.base.answers_hello = false;
  ExpectRefused(bus, "", {"usb base A17", "no HELLO in time"});
}

TEST(UsbTransport, RejectsOtherProtocolVersions) {
  FakeUsbBus bus;
  wire::Hello& hello = bus.Add("A17").base.hello;
  hello.version_min = 2;
  hello.version_max = 3;
  ExpectRefused(bus, "", {"speaks protocol versions 2 to 3", "this service speaks 1"});
  hello.version_min = 1;
  EXPECT_TRUE(MakeUsbTransport(bus, "").ok()) << "1 is within 1 to 3";
}

TEST(UsbTransport, RejectsHelloWithImplausibleScales) {
  for (const float field_lsb_T : {1e-30F, 1.0F}) {
    FakeUsbBus bus;
    bus.Add("A17").base.hello.field_lsb_T = field_lsb_T;
    ExpectRefused(bus, "", {"which is not plausible"});
  }
  FakeUsbBus bus;
  bus.Add("A17").base.hello.current_max_A = 1e6F;
  ExpectRefused(bus, "", {"which is not plausible"});
}

// The link on its thread, the tick on this one: scans in order and intact, no allocation in Read and Write.
TEST(UsbTransport, ReadAndWriteAcrossThreadsNeverAllocate) {
  FakeUsbBus bus(true);
  test::FakeBase& base = bus.Add("A17").base;
  const auto transport = MakeUsbTransport(bus, "");
  ASSERT_TRUE(transport.ok()) << transport.error();
  base::HallScan before;
  std::uint64_t allocations = 0;
  for (int i = 0; i < 500; ++i) {
    base::HallScan scan;
    const loop::AllocProbe quiet;
    const ReadStatus read = (*transport)->Read(scan, kPatience_ns);
    const bool written = (*transport)->Write({{0.001 * i, 0, 0}});
    allocations += quiet.count();
    ASSERT_EQ(read, ReadStatus::kScan);
    ASSERT_TRUE(written);
    ASSERT_GT(scan.sequence, before.sequence);
    ASSERT_GE(scan.t_ns, before.t_ns);
    before = scan;
  }
  EXPECT_EQ(allocations, 0U);
  EXPECT_EQ((*transport)->state().state, static_cast<std::uint8_t>(wire::State::kArmed));
  const TransportCounters counters = (*transport)->counters();
  EXPECT_EQ(counters.bad_frames, 0U);
  EXPECT_GE(counters.received, 500U);
  EXPECT_EQ(base.bad, 0);
}

TEST(UsbTransport, ReopensAndRearmsAnUnpluggedBase) {
  FakeUsbBus bus;
  test::FakeBase& base = bus.Add("A17").base;
  for (int plugged = 0; plugged < 3; ++plugged) {
    base.state = wire::State::kIdle;  // it has lost its supply, and its clock
    base.faults = wire::kFaultNotArmed;
    base.t_us = 0;
    base.seq = 0;
    base.telemetry.ack_seq = 0;
    const auto transport = MakeUsbTransport(bus, "");
    ASSERT_TRUE(transport.ok()) << transport.error();
    base::HallScan scan;
    for (int i = 0; i < 5; ++i) {
      bus.link->Step();
      ASSERT_EQ((*transport)->Read(scan, 0), ReadStatus::kScan);
      (*transport)->Write({{1, 0, 0}});
      bus.link->Pump();
    }
    EXPECT_EQ(base.state, wire::State::kArmed) << plugged;
    bus.link->Unplug();
    EXPECT_EQ((*transport)->Read(scan, kShort_ns), ReadStatus::kGone);
    EXPECT_FALSE((*transport)->Write({{1, 0, 0}}));
  }
}

}  // namespace test_device_usb_transport
}  // namespace omni::device
