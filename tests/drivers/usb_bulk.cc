// Frames both ways: sizes around the packet size, full queues on either side, errors on the wire, non-coherent caches.
#include <gtest/gtest.h>

#include <string>

#include "tests/support/chips/usb_bench.h"

namespace omni::drivers::usb {
namespace test_drivers_usb_bulk {

using support::UsbBench;
using Status = support::UsbHost::Status;
using Bytes = UsbBench::Bytes;

// At high and at full speed.
struct UsbBulk : testing::TestWithParam<bool>, UsbBench {
  void SetUp() override {
    controller.stir = true;
    ASSERT_TRUE(device.Start());
    ASSERT_TRUE(host.Enumerate(GetParam()));
    ASSERT_EQ(device.high_speed(), GetParam());
  }
  void TearDown() override {
    EXPECT_TRUE(controller.complaints().empty()) << controller.complaints().front();
    EXPECT_EQ(device.counters().timeouts, 0U);
  }
};

std::string SpeedName(const testing::TestParamInfo<bool>& speed) { return speed.param ? "High" : "Full"; }
INSTANTIATE_TEST_SUITE_P(Speeds, UsbBulk, testing::Values(true, false), SpeedName);

TEST_P(UsbBulk, TransfersFramesOfEverySize) {
  for (std::size_t size = 1; size <= 512; ++size) {
    const Bytes frame = UsbBench::Frame(size, static_cast<int>(size));
    // 512 bytes are a whole buffer and need no empty packet; at full speed a frame of n times 64 does.
    ASSERT_EQ(host.BulkOut(frame, size < 512), Status::kOk) << size;
    ASSERT_EQ(Receive(), frame) << size;
    ASSERT_TRUE(Send(frame));
    const auto result = host.BulkIn();
    ASSERT_EQ(result.status, Status::kOk) << size;
    ASSERT_EQ(result.data, frame) << size;
  }
  EXPECT_EQ(device.counters().received, 512U);
  EXPECT_EQ(device.counters().sent, 512U);
  EXPECT_TRUE(Receive().empty());
}

TEST_P(UsbBulk, IgnoresEmptyTransfers) {
  ASSERT_EQ(host.BulkOut({}), Status::kOk);
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(5, 1)), Status::kOk);
  EXPECT_EQ(Receive(), UsbBench::Frame(5, 1));
  EXPECT_TRUE(Receive().empty());
}

TEST_P(UsbBulk, FullReceiveQueueMakesTheHostWait) {
  for (int i = 0; i < kReceiveDepth; ++i) ASSERT_EQ(host.BulkOut(UsbBench::Frame(60, i)), Status::kOk);
  EXPECT_EQ(host.BulkOut(UsbBench::Frame(60, 99)), Status::kTimeout) << "NAK, nothing lost";
  EXPECT_EQ(Receive(), UsbBench::Frame(60, 0));
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(60, kReceiveDepth)), Status::kOk);
  for (int i = 1; i <= kReceiveDepth; ++i) EXPECT_EQ(Receive(), UsbBench::Frame(60, i));
  EXPECT_TRUE(Receive().empty());
}

TEST_P(UsbBulk, FullSendQueueKeepsTheNewestFrames) {
  for (int i = 0; i < 100; ++i) ASSERT_TRUE(Send(UsbBench::Frame(60, i)));
  EXPECT_EQ(device.counters().send_overwritten, 96U);
  EXPECT_EQ(host.BulkIn().data, UsbBench::Frame(60, 0)) << "was in transit";
  EXPECT_EQ(host.BulkIn().data, UsbBench::Frame(60, 97));
  EXPECT_EQ(host.BulkIn().data, UsbBench::Frame(60, 98));
  EXPECT_EQ(host.BulkIn().data, UsbBench::Frame(60, 99));
  EXPECT_EQ(host.BulkIn().status, Status::kTimeout);
}

TEST_P(UsbBulk, RejectsInvalidFrameSizes) {
  EXPECT_FALSE(Send({}));
  EXPECT_FALSE(Send(Bytes(513)));
  EXPECT_EQ(device.counters().send_refused, 2U);
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(60, 1)), Status::kOk);
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(20, 2)), Status::kOk);
  std::uint8_t small[32] = {};
  EXPECT_EQ(device.Receive(small, sizeof small), 0U) << "does not fit, discarded";
  EXPECT_EQ(device.Receive(small, sizeof small), 20U);
}

TEST_P(UsbBulk, DiscardsAndCountsDamagedTransfers) {
  controller.DamageNext(1, false);
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(60, 1)), Status::kOk) << "the host repeats";
  EXPECT_EQ(device.counters().receive_errors, 1U);
  EXPECT_EQ(Receive(), UsbBench::Frame(60, 1));
  controller.DamageNext(1, true);
  ASSERT_TRUE(Send(UsbBench::Frame(60, 1)));
  ASSERT_TRUE(Send(UsbBench::Frame(60, 2)));
  EXPECT_EQ(host.BulkIn().data, UsbBench::Frame(60, 2));
  EXPECT_EQ(device.counters().send_errors, 1U);
  EXPECT_GE(device.counters().bus_errors, 2U);
}

// The host repeats a packet whose acknowledgement it missed: the controller discards the copy.
TEST_P(UsbBulk, RepeatedPacketIsDeliveredOnce) {
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(30, 1)), Status::kOk);
  host.out_toggle = 1 - host.out_toggle;
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(30, 1)), Status::kOk);
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(30, 2)), Status::kOk);
  EXPECT_EQ(Receive(), UsbBench::Frame(30, 1));
  EXPECT_EQ(Receive(), UsbBench::Frame(30, 2));
  EXPECT_TRUE(Receive().empty());
}

TEST_P(UsbBulk, CarriesTenSecondsOfTelemetryAndCommands) {
  for (int i = 0; i < 10'000; ++i) {
    const Bytes telemetry = UsbBench::Frame(160, i);
    const Bytes command = UsbBench::Frame(52, 3 * i);
    ASSERT_TRUE(Send(telemetry));
    ASSERT_EQ(host.BulkIn().data, telemetry);
    ASSERT_EQ(host.BulkOut(command), Status::kOk);
    ASSERT_EQ(Receive(), command);
  }
  EXPECT_EQ(device.counters().send_overwritten, 0U);
}

}  // namespace test_drivers_usb_bulk
}  // namespace omni::drivers::usb
