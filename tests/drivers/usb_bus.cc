// Bus events: resets in the middle of transfers, suspend, unplugging, SETUPs at the worst moment, a hanging controller.
#include <gtest/gtest.h>

#include "tests/support/chips/usb_bench.h"

namespace omni::drivers::usb {
namespace test_drivers_usb_bus {

using support::UsbBench;
using Status = support::UsbHost::Status;
using Bytes = UsbBench::Bytes;

struct UsbBus : testing::Test, UsbBench {
  void SetUp() override {
    controller.stir = true;
    ASSERT_TRUE(device.Start());
    ASSERT_TRUE(host.Enumerate());
  }
  void TearDown() override { EXPECT_TRUE(controller.complaints().empty()) << controller.complaints().front(); }
  void ExpectWorks(int seed) {
    ASSERT_EQ(host.BulkOut(UsbBench::Frame(52, seed)), Status::kOk);
    EXPECT_EQ(Receive(), UsbBench::Frame(52, seed));
    ASSERT_TRUE(Send(UsbBench::Frame(160, seed)));
    EXPECT_EQ(host.BulkIn().data, UsbBench::Frame(160, seed));
  }
};

TEST_F(UsbBus, BusResetDropsQueuedFramesAndRecovers) {
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(52, 1)), Status::kOk);
  ASSERT_TRUE(Send(UsbBench::Frame(160, 1)));
  ASSERT_TRUE(Send(UsbBench::Frame(160, 2)));
  host.Reset(true);
  EXPECT_EQ(device.state(), DeviceState::kDefault);
  EXPECT_TRUE(Receive().empty()) << "an old command is not acted upon";
  EXPECT_FALSE(Send(UsbBench::Frame(160, 3)));
  EXPECT_EQ(device.counters().lost_in_reset, 3U);
  ASSERT_TRUE(host.Enumerate());
  EXPECT_EQ(host.BulkIn().status, Status::kTimeout) << "nothing from before the reset";
  ExpectWorks(4);
}

TEST_F(UsbBus, BusResetDiscardsPartialTransfers) {
  ASSERT_TRUE(host.Enumerate(false));
  // Full speed: frames of several packets; one packet of each goes, then the reset.
  ASSERT_TRUE(Send(UsbBench::Frame(160, 1)));
  ASSERT_EQ(controller.In(host.address, 1).data.size(), 64U);
  ASSERT_EQ(controller.Out(host.address, 1, host.out_toggle, UsbBench::Frame(64, 1)),
            support::ChipideaModel::Answer::kAck);
  ASSERT_TRUE(host.Enumerate(false));
  ExpectWorks(5);
  EXPECT_EQ(device.counters().received, 1U);
}

TEST_F(UsbBus, ClearHaltRestartsPartialTransfers) {
  ASSERT_TRUE(host.Enumerate(false));
  ASSERT_TRUE(Send(UsbBench::Frame(160, 1)));
  ASSERT_EQ(controller.In(host.address, 1).data.size(), 64U);
  ASSERT_EQ(controller.Out(host.address, 1, host.out_toggle, UsbBench::Frame(64, 1)),
            support::ChipideaModel::Answer::kAck);
  ASSERT_EQ(host.Control({0x02, 1, 0, 0x01, 0}).status, Status::kOk);
  ASSERT_EQ(host.Control({0x02, 1, 0, 0x81, 0}).status, Status::kOk);
  host.ResetToggles();
  EXPECT_EQ(host.BulkIn().data, UsbBench::Frame(160, 1)) << "from its beginning";
  ExpectWorks(6);
}

TEST_F(UsbBus, BusResetDuringControlTransferRecovers) {
  for (const bool before_interrupt : {false, true}) {
    if (before_interrupt) {
      controller.Setup(host.address, {0x00, 5, 99, 0, 0, 0, 0, 0});
    } else {
      ASSERT_TRUE(host.Begin({0x00, 5, 99, 0, 0}));
    }
    host.Reset(true);
    EXPECT_EQ(host.GetDescriptor(1).data.size(), 18U) << "at address 0, not 99";
    ASSERT_TRUE(host.Enumerate());
    ASSERT_TRUE(host.Begin({0xC0, 0x20, 0, 7, 162}));
    ASSERT_EQ(controller.In(host.address, 0).data.size(), 64U);
    ASSERT_TRUE(host.Enumerate());
    ExpectWorks(6);
  }
}

TEST_F(UsbBus, CountsLateBusResetsAndRecovers) {
  controller.BeginReset();
  controller.EndReset(true);
  host.Service();
  EXPECT_EQ(device.counters().late_resets, 1U);
  EXPECT_EQ(device.state(), DeviceState::kDefault);
  ASSERT_TRUE(host.Enumerate());
  ExpectWorks(7);
}

TEST_F(UsbBus, HostMayEndTheDataStageEarly) {
  ASSERT_TRUE(host.Begin({0xC0, 0x20, 0, 7, 162}));
  ASSERT_EQ(controller.In(host.address, 0).data.size(), 64U);
  EXPECT_EQ(controller.Out(host.address, 0, 1, {}), support::ChipideaModel::Answer::kAck) << "status stage";
  EXPECT_EQ(host.GetDescriptor(1).data.size(), 18U);
}

TEST_F(UsbBus, SuspendStopsSendingUntilResume) {
  ASSERT_TRUE(Send(UsbBench::Frame(160, 1)));
  controller.Suspend();
  host.Service();
  EXPECT_TRUE(device.suspended());
  EXPECT_FALSE(Send(UsbBench::Frame(160, 2)));
  EXPECT_EQ(host.BulkIn().status, Status::kTimeout);
  controller.Resume();
  host.Service();
  EXPECT_FALSE(device.suspended());
  EXPECT_EQ(device.state(), DeviceState::kConfigured);
  EXPECT_TRUE(device.high_speed());
  EXPECT_EQ(host.BulkIn().data, UsbBench::Frame(160, 1)) << "kept";
  ExpectWorks(8);
  EXPECT_EQ(device.counters().suspends, 1U);
}

TEST_F(UsbBus, BusResetEndsSuspend) {
  controller.Suspend();
  host.Service();
  ASSERT_TRUE(host.Enumerate());
  EXPECT_FALSE(device.suspended());
  ExpectWorks(9);
}

TEST_F(UsbBus, UnplugDetachesAndReplugRecovers) {
  for (int i = 0; i < 3; ++i) {
    ASSERT_EQ(host.BulkOut(UsbBench::Frame(52, 1)), Status::kOk);
    ASSERT_TRUE(Send(UsbBench::Frame(160, 1)));
    controller.Unplug();
    host.Service();
    EXPECT_EQ(device.state(), DeviceState::kDetached);
    EXPECT_FALSE(controller.running()) << "no pull-up without a host's voltage";
    EXPECT_TRUE(Receive().empty());
    EXPECT_FALSE(Send(UsbBench::Frame(160, 1)));
    controller.Plug();
    host.Service();
    EXPECT_EQ(device.state(), DeviceState::kDefault);
    EXPECT_TRUE(controller.running());
    ASSERT_TRUE(host.Enumerate());
    ExpectWorks(i);
  }
  EXPECT_EQ(device.counters().unplugs, 3U);
}

// The tripwire: the second SETUP overwrites the first while it is copied. Only the second one may be answered.
TEST_F(UsbBus, SetupArrivingDuringCopySupersedesThePrevious) {
  controller.while_copying = [&] { controller.Setup(host.address, {0x80, 6, 0, 1, 0, 0, 18, 0}); };
  controller.Setup(host.address, {0x40, 1, 0, 0, 0, 0, 0, 0});
  host.Service();
  EXPECT_EQ(handler.stops, 0) << "abandoned by the host";
  EXPECT_EQ(device.counters().setups, 3U) << "address, configuration, and one";
  EXPECT_EQ(controller.In(host.address, 0).data.size(), 18U);
  ExpectWorks(10);
}

TEST_F(UsbBus, SetupArrivingDuringPrimingSupersedesThePrevious) {
  controller.while_priming = [&] { controller.Setup(host.address, {0x80, 8, 0, 0, 0, 0, 1, 0}); };
  controller.Setup(host.address, {0x80, 6, 0, 1, 0, 0, 18, 0});
  host.Service();
  EXPECT_EQ(controller.In(host.address, 0).data, Bytes{1}) << "the newer one's answer";
  EXPECT_EQ(host.GetDescriptor(1).data.size(), 18U);
}

TEST_F(UsbBus, AnswersOnlyTheLastOfBackToBackSetups) {
  for (int i = 0; i < 50; ++i) {
    for (int k = 0; k <= i % 4; ++k) controller.Setup(host.address, {0x80, 6, 0, 2, 0, 0, 32, 0});
    EXPECT_EQ(host.GetDescriptor(1).data.size(), 18U);
    ASSERT_TRUE(host.Begin({0xC0, 0x20, 0, 7, 162}));  // abandoned before its data
  }
  ExpectWorks(11);
}

TEST_F(UsbBus, SpuriousInterruptsAreHarmless) {
  for (int i = 0; i < 100; ++i) device.HandleInterrupt();
  ExpectWorks(12);
  ASSERT_EQ(host.BulkOut(UsbBench::Frame(52, 1)), Status::kOk);
  for (int i = 0; i < 100; ++i) device.HandleInterrupt();
  EXPECT_EQ(Receive(), UsbBench::Frame(52, 1));
  EXPECT_TRUE(Receive().empty());
}

TEST_F(UsbBus, StopLeavesTheBusAndStartRejoinsIt) {
  device.Stop();
  EXPECT_FALSE(controller.running());
  EXPECT_EQ(device.state(), DeviceState::kOff);
  device.HandleInterrupt();
  EXPECT_EQ(host.GetDescriptor(1).status, Status::kTimeout);
  ASSERT_TRUE(device.Start());
  ASSERT_TRUE(host.Enumerate());
  ExpectWorks(13);
}

TEST_F(UsbBus, StartFailsWhileTheControllerHangs) {
  controller.stuck = true;
  host.Reset(true);
  EXPECT_GT(device.counters().timeouts, 0U);
  EXPECT_FALSE(device.Start());
  EXPECT_EQ(device.state(), DeviceState::kOff);
  EXPECT_FALSE(Send(UsbBench::Frame(10, 1)));
  controller.stuck = false;
  ASSERT_TRUE(device.Start());
  ASSERT_TRUE(host.Enumerate());
  ExpectWorks(14);
}

}  // namespace test_drivers_usb_bus
}  // namespace omni::drivers::usb
