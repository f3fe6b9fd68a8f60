// Endpoint 0 as a host uses it: every descriptor, addresses, configurations, halts, vendor requests, and refusals.
#include <gtest/gtest.h>

#include <string>

#include "firmware/wire/usb_ids.h"
#include "tests/support/chips/usb_bench.h"

namespace omni::drivers::usb {
namespace test_drivers_usb_enumerate {

using support::UsbBench;
using Status = support::UsbHost::Status;
using Bytes = UsbBench::Bytes;

struct UsbEnumerate : testing::Test, UsbBench {
  void SetUp() override {
    ASSERT_TRUE(device.Start());
    host.Reset(true);
  }
  void TearDown() override {
    EXPECT_TRUE(controller.complaints().empty()) << controller.complaints().front();
    EXPECT_EQ(device.counters().timeouts, 0U);
    EXPECT_EQ(device.counters().late_resets, 0U);
  }
  Bytes Get(int type, int index = 0, std::uint16_t length = 4096) {
    const auto result = host.GetDescriptor(type, index, length);
    EXPECT_EQ(result.status, Status::kOk);
    return result.data;
  }
  std::string Text(int index) {
    const Bytes bytes = Get(3, index);
    EXPECT_EQ(bytes.size(), bytes[0]);
    std::string text;
    for (std::size_t i = 2; i + 1 < bytes.size(); i += 2) text += static_cast<char>(bytes[i]);
    return text;
  }
};

constexpr std::uint16_t kBulkEndpoints[] = {kEndpointOut, kEndpointIn};

int Word(const Bytes& bytes, std::size_t at) { return bytes.at(at) | (bytes.at(at + 1) << 8); }

TEST_F(UsbEnumerate, MatchesLinuxRequestSequence) {
  EXPECT_EQ(device.state(), DeviceState::kDefault);
  const Bytes first = Get(1, 0, 64);
  ASSERT_EQ(first.size(), 18U);
  EXPECT_EQ(first[7], 64);
  host.Reset(true);
  ASSERT_TRUE(host.SetAddress(42));
  EXPECT_EQ(device.state(), DeviceState::kAddress);
  const Bytes device_descriptor = Get(1, 0, 18);
  EXPECT_EQ(Word(device_descriptor, 2), 0x0210);
  EXPECT_EQ(Word(device_descriptor, 8), 0x1209);
  EXPECT_EQ(Word(device_descriptor, 10), 0x0001);
  EXPECT_EQ(Get(15, 0, 5).size(), 5U);
  EXPECT_EQ(Get(15).size(), 57U);
  EXPECT_EQ(Get(6).size(), 10U);
  const Bytes head = Get(2, 0, 9);
  ASSERT_EQ(head.size(), 9U);
  const Bytes whole = Get(2, 0, static_cast<std::uint16_t>(Word(head, 2)));
  EXPECT_EQ(whole.size(), 32U);
  EXPECT_EQ(Get(3, 0), (Bytes{4, 3, 0x09, 0x04}));
  EXPECT_EQ(Text(1), "Omni");
  EXPECT_EQ(Text(2), wire::kUsbProductName);
  EXPECT_EQ(Text(3), "0123456789abcdef");
  ASSERT_EQ(host.Configure(), Status::kOk);
  EXPECT_EQ(device.state(), DeviceState::kConfigured);
  EXPECT_EQ(host.Control({0x80, 8, 0, 0, 1}).data, Bytes{1});
}

TEST_F(UsbEnumerate, OtherSpeedConfigurationReportsItsPacketSize) {
  const auto packet = [](const Bytes& configuration) { return Word(configuration, 22); };
  EXPECT_TRUE(device.high_speed());
  EXPECT_EQ(packet(Get(2)), 512);
  EXPECT_EQ(packet(Get(7)), 64);
  EXPECT_EQ(Get(7)[1], 7);
  host.Reset(false);
  EXPECT_FALSE(device.high_speed());
  EXPECT_EQ(packet(Get(2)), 64);
  EXPECT_EQ(packet(Get(7)), 512);
}

// Walks the configuration as a host does: lengths add up to the total, endpoints are the ones in use.
TEST_F(UsbEnumerate, ConfigurationDescriptorLengthsAddUp) {
  const Bytes bytes = Get(2);
  int interfaces = 0;
  Bytes endpoints;
  std::size_t at = 0;
  for (; at < bytes.size(); at += bytes[at]) {
    ASSERT_GE(bytes[at], 2);
    if (bytes[at + 1] == 4) {
      ++interfaces;
      EXPECT_EQ(bytes[at + 5], 0xFF);
      EXPECT_EQ(bytes[at + 4], 2);
    }
    if (bytes[at + 1] == 5) endpoints.push_back(bytes[at + 2]);
  }
  EXPECT_EQ(at, bytes.size());
  EXPECT_EQ(interfaces, 1);
  EXPECT_EQ(endpoints, (Bytes{0x01, 0x81}));
}

// As Windows: the capability gives length and vendor code of the set, its lengths add up, it has WINUSB and one GUID.
TEST_F(UsbEnumerate, MsOsDescriptorsSelectWinUsb) {
  const Bytes bos = Get(15);
  const std::size_t at = 5;
  ASSERT_EQ(bos[at + 1], 16);
  ASSERT_EQ(bos[at + 2], 5);
  EXPECT_EQ(bos[at + 4], 0xDF);
  const int size = Word(bos, at + 24);
  const std::uint8_t code = bos[at + 26];
  EXPECT_EQ(code, 0x20);
  const auto result = host.Control({0xC0, code, 0, 7, static_cast<std::uint16_t>(size)});
  ASSERT_EQ(result.status, Status::kOk);
  const Bytes& set = result.data;
  ASSERT_EQ(static_cast<int>(set.size()), size);
  EXPECT_EQ(Word(set, 8), size);
  std::size_t next = static_cast<std::size_t>(Word(set, 0));
  EXPECT_EQ(Word(set, next + 2), 3);
  EXPECT_EQ(std::string(set.begin() + 14, set.begin() + 20), "WINUSB");
  next += static_cast<std::size_t>(Word(set, next));
  EXPECT_EQ(Word(set, next + 2), 4);
  EXPECT_EQ(Word(set, next + 4), 7) << "REG_MULTI_SZ";
  const auto name_size = static_cast<std::size_t>(Word(set, next + 6));
  const auto data_size = static_cast<std::size_t>(Word(set, next + 8 + name_size));
  const std::size_t data = next + 8 + name_size + 2;
  EXPECT_EQ(data + data_size, set.size());
  EXPECT_EQ(data_size, 2 * (38U + 2U)) << "one GUID, two zeros";
  EXPECT_EQ(set[data], '{');
  EXPECT_EQ(set[data + 2 * 37], '}');
  EXPECT_EQ(Bytes(set.end() - 4, set.end()), Bytes(4));
  EXPECT_EQ(host.Control({0xC0, code, 0, 8, 10}).status, Status::kStall);
}

TEST_F(UsbEnumerate, WebUsbCapabilityHasNoLandingPage) {
  const Bytes bos = Get(15);
  const std::size_t at = 5 + 28;
  EXPECT_EQ(bos[at + 4], 0x38);
  EXPECT_EQ(Word(bos, at + 20), 0x0100);
  EXPECT_EQ(bos[at + 22], 0x21);
  EXPECT_EQ(bos[at + 23], 0);
  EXPECT_EQ(host.Control({0xC0, 0x21, 1, 2, 255}).status, Status::kStall);
}

TEST_F(UsbEnumerate, AnswersAreCutToTheRequestedLength) {
  constexpr std::uint16_t kLengths[] = {1, 8, 63, 64, 65, 128, 161, 162, 163, 192, 4096};
  for (const std::uint16_t length : kLengths) {
    const auto result = host.Control({0xC0, 0x20, 0, 7, length});
    ASSERT_EQ(result.status, Status::kOk) << length;
    EXPECT_EQ(result.data.size(), length < 162 ? length : 162U);
  }
  EXPECT_EQ(host.GetDescriptor(1, 0, 0).status, Status::kOk) << "nothing requested, nothing sent";
}

// An answer of exactly 64 or 128 bytes where more was requested: an empty packet marks its end.
TEST_F(UsbEnumerate, FullLastPacketIsFollowedByAZeroLengthPacket) {
  for (const std::size_t size : {64U, 128U, 512U}) {
    handler.hello_size = size;
    const auto result = host.Control({0xC0, 2, 0, 0, 4096});
    ASSERT_EQ(result.status, Status::kOk) << size;
    EXPECT_EQ(result.data, UsbBench::Frame(size, 0x40));
    const auto exact = host.Control({0xC0, 2, 0, 0, static_cast<std::uint16_t>(size)});
    ASSERT_EQ(exact.status, Status::kOk) << size;
    EXPECT_EQ(exact.data.size(), size);
  }
}

TEST_F(UsbEnumerate, HelloAndEmergencyStopNeedNoConfiguration) {
  EXPECT_EQ(host.Control({0xC0, 2, 0, 0, 511}).data, UsbBench::Frame(72, 0x40));
  EXPECT_EQ(host.Control({0x40, 1, 0, 0, 0}).status, Status::kOk);
  EXPECT_EQ(host.Control({0x40, 1, 0, 0, 0}).status, Status::kOk);
  EXPECT_EQ(handler.stops, 2);
  handler.hello_size = 0;
  EXPECT_EQ(host.Control({0xC0, 2, 0, 0, 511}).status, Status::kStall);
  handler.hello_size = 513;
  EXPECT_EQ(host.Control({0xC0, 2, 0, 0, 511}).status, Status::kStall);
  // The host gives up before the status stage: the stop counts.
  ASSERT_TRUE(host.Begin({0x40, 1, 0, 0, 0}));
  EXPECT_EQ(handler.stops, 3);
}

TEST_F(UsbEnumerate, UnknownRequestsStallAndTheNextOneWorks) {
  ASSERT_TRUE(host.SetAddress(5));
  const support::UsbRequest kRefused[] = {
      {0x80, 6, 0x0500, 0, 64},  // an endpoint's descriptor
      {0x80, 6, 0x0101, 0, 64},  // a second device
      {0x80, 6, 0x0304, 0, 64},  // no such string
      {0x80, 6, 0x03EE, 0, 64},  // MS OS 1.0
      {0x00, 9, 2, 0, 0},        // no such configuration
      {0x00, 9, 1, 0, 4},        // with data
      {0x00, 5, 128, 0, 0},      // no such address
      {0x00, 7, 0x0100, 0, 18},  // SET_DESCRIPTOR
      {0x00, 3, 1, 0, 0},        // remote wake-up
      {0x02, 1, 0, 0x81, 0},     // not configured: no such endpoint
      {0x82, 0, 0, 0x81, 2},     // as above
      {0x81, 10, 0, 0, 1},       // as above
      {0x01, 11, 0, 0, 0},       // as above
      {0x81, 0, 0, 0, 2},        // as above
      {0x40, 1, 0, 0, 8},        // estop with data
      {0xC0, 1, 0, 0, 8},        // estop in the wrong direction
      {0xC1, 2, 0, 0, 64},       // hello of the interface
      {0x40, 0x7F, 0, 0, 0},     // no such vendor request
      {0xA1, 0x01, 0, 0, 8},     // a class request
      {0xFF, 0xFF, 0xFFFF, 0xFFFF, 0xFFFF},
  };
  std::uint32_t stalls = 0;
  for (const support::UsbRequest& request : kRefused) {
    EXPECT_EQ(host.Control(request).status, Status::kStall) << int{request.type} << " " << int{request.request};
    EXPECT_EQ(device.counters().stalls, ++stalls);
    EXPECT_EQ(Get(1, 0, 18).size(), 18U);
  }
  EXPECT_EQ(handler.stops, 0);
  EXPECT_EQ(device.state(), DeviceState::kAddress);
}

TEST_F(UsbEnumerate, ReportsStatusOfDeviceInterfaceAndEndpoints) {
  const Bytes zero{0, 0};
  EXPECT_EQ(host.Control({0x80, 0, 0, 0, 2}).data, zero);
  EXPECT_EQ(host.Control({0x82, 0, 0, 0, 2}).data, zero);
  EXPECT_EQ(host.Control({0x82, 0, 0, 0x80, 2}).data, zero);
  ASSERT_EQ(host.Configure(), Status::kOk);
  EXPECT_EQ(host.Control({0x81, 0, 0, 0, 2}).data, zero);
  EXPECT_EQ(host.Control({0x81, 10, 0, 0, 1}).data, Bytes{0});
  EXPECT_EQ(host.Control({0x01, 11, 1, 0, 0}).status, Status::kStall) << "no alternate setting";
  EXPECT_EQ(host.Control({0x81, 0, 0, 1, 2}).status, Status::kStall) << "no such interface";
  EXPECT_EQ(host.Control({0x82, 0, 0, 0x82, 2}).status, Status::kStall) << "no such endpoint";
  EXPECT_EQ(host.Control({0x02, 1, 0, 0x02, 0}).status, Status::kStall) << "no such endpoint";
}

TEST_F(UsbEnumerate, HaltedEndpointsStallUntilCleared) {
  ASSERT_EQ(host.Configure(), Status::kOk);
  const Bytes frame = UsbBench::Frame(100, 1);
  // Odd toggles, so that a clear that forgot them would show.
  ASSERT_EQ(host.BulkOut(frame), Status::kOk);
  ASSERT_TRUE(Send(frame));
  ASSERT_EQ(host.BulkIn().data, frame);
  for (const std::uint16_t endpoint : kBulkEndpoints) {
    ASSERT_EQ(host.Control({0x02, 3, 0, endpoint, 0}).status, Status::kOk);
    EXPECT_EQ(host.Control({0x82, 0, 0, endpoint, 2}).data, (Bytes{1, 0}));
  }
  ASSERT_TRUE(Send(frame));
  EXPECT_EQ(host.BulkOut(frame), Status::kStall);
  EXPECT_EQ(host.BulkIn().status, Status::kStall);
  for (const std::uint16_t endpoint : kBulkEndpoints) {
    ASSERT_EQ(host.Control({0x02, 1, 0, endpoint, 0}).status, Status::kOk);
    EXPECT_EQ(host.Control({0x82, 0, 0, endpoint, 2}).data, (Bytes{0, 0}));
  }
  host.ResetToggles();
  EXPECT_EQ(host.BulkIn().data, frame);
  EXPECT_EQ(Receive(), frame);
  EXPECT_EQ(host.BulkOut(UsbBench::Frame(60, 9)), Status::kOk);
  EXPECT_EQ(Receive(), UsbBench::Frame(60, 9));
}

TEST_F(UsbEnumerate, SetInterfaceResetsDataToggles) {
  ASSERT_EQ(host.Configure(), Status::kOk);
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(10, 1)), Status::kOk);
  ASSERT_EQ(host.Control({0x01, 11, 0, 0, 0}).status, Status::kOk);
  host.ResetToggles();
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(10, 2)), Status::kOk);
  EXPECT_EQ(Receive(), UsbBench::Frame(10, 1));
  EXPECT_EQ(Receive(), UsbBench::Frame(10, 2));
}

TEST_F(UsbEnumerate, ConfigurationZeroClosesTheEndpoints) {
  ASSERT_EQ(host.Configure(), Status::kOk);
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(10, 1)), Status::kOk);
  ASSERT_EQ(host.Configure(0), Status::kOk);
  EXPECT_EQ(device.state(), DeviceState::kAddress);
  EXPECT_TRUE(Receive().empty());
  EXPECT_EQ(host.BulkOut(UsbBench::Frame(10, 1)), Status::kTimeout);
  EXPECT_FALSE(Send(UsbBench::Frame(10, 1)));
  ASSERT_EQ(host.Configure(), Status::kOk);
  EXPECT_EQ(host.BulkOut(UsbBench::Frame(10, 3)), Status::kOk);
  EXPECT_EQ(Receive(), UsbBench::Frame(10, 3));
}

}  // namespace test_drivers_usb_enumerate
}  // namespace omni::drivers::usb
