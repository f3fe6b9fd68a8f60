// The descriptors contain the IDs that host and udev rule use: the drivers include no other code of ours, so the
// numbers exist twice.
#include <gtest/gtest.h>

#include "firmware/drivers/usb_control.h"
#include "firmware/drivers/usb_queue.h"
#include "firmware/wire/messages.h"
#include "firmware/wire/usb_ids.h"

namespace omni::drivers::usb {
namespace test_drivers_usb_ids {

ControlAction ActionOf(std::uint8_t type, wire::UsbRequest request, std::uint16_t index) {
  std::uint8_t data[512];
  return AnswerControl({type, static_cast<std::uint8_t>(request), 0, index, 0}, ControlState(), data).action;
}

TEST(UsbIds, MatchTheWireConstants) {
  EXPECT_EQ(kVendorId, wire::kUsbVendorId);
  EXPECT_EQ(kProductId, wire::kUsbProductId);
  EXPECT_EQ(kConfigurationHigh[14], wire::kUsbInterfaceClass);
  EXPECT_EQ(kConfigurationHigh[15], wire::kUsbInterfaceSubclass);
  EXPECT_EQ(kConfigurationHigh[16], wire::kUsbInterfaceProtocol);
  EXPECT_EQ(ActionOf(wire::kUsbRequestTypeOut, wire::UsbRequest::kEstop, 0), ControlAction::kEstop);
  EXPECT_EQ(ActionOf(wire::kUsbRequestTypeIn, wire::UsbRequest::kHello, 0), ControlAction::kHello);
  EXPECT_EQ(ActionOf(wire::kUsbRequestTypeIn, wire::UsbRequest::kMsOs20, 7), ControlAction::kData);
  EXPECT_EQ(kRequestMsOs, static_cast<std::uint8_t>(wire::UsbRequest::kMsOs20));
  EXPECT_EQ(kRequestWebUsb, static_cast<std::uint8_t>(wire::UsbRequest::kWebUsb));
}

// An emergency stop may give a reason in wValue; it stops for any value.
TEST(UsbIds, EmergencyStopAcceptsAnyReason) {
  std::uint8_t data[512];
  for (int reason = 0; reason <= 0xFFFF; ++reason) {
    const usb::Setup setup{wire::kUsbRequestTypeOut, kRequestEstop, static_cast<std::uint16_t>(reason), 0, 0};
    ASSERT_EQ(AnswerControl(setup, ControlState(), data).action, ControlAction::kEstop);
  }
}

// One frame is one transfer: a whole one fits a buffer and, at high speed, one packet that is not full.
TEST(UsbIds, FramesFitTheirBuffers) {
  EXPECT_LT(wire::kFrameSizeMax, kBufferSize);
  EXPECT_LT(wire::kFrameSizeMax, kBulkPacketHigh);
  EXPECT_LE(sizeof(wire::Hello::serial), kSerialMax);
}

}  // namespace test_drivers_usb_ids
}  // namespace omni::drivers::usb
