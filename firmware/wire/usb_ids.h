// The base's USB identifiers, the same for firmware, host and udev. Endpoint addresses are not included: the host reads
// those of the interface's bulk endpoints from the descriptors.
#pragma once

#include <cstdint>

namespace omni::wire {

// pid.codes' number for tests, private use only; a base that is sold needs one of its own.
constexpr std::uint16_t kUsbVendorId = 0x1209;
constexpr std::uint16_t kUsbProductId = 0x0001;
// Others use that number too: a base is a device with it, with this product string and the interface below.
constexpr char kUsbProductName[] = "Omni haptic base";

// The one interface: vendor specific, one bulk IN and one bulk OUT. One frame is one transfer.
constexpr std::uint8_t kUsbInterfaceClass = 0xFF;
constexpr std::uint8_t kUsbInterfaceSubclass = 0x00;
constexpr std::uint8_t kUsbInterfaceProtocol = 0x00;

// Vendor requests of endpoint 0, recipient device [USB 2.0, 9.3]: they do not require claiming the interface, so they
// work while another program holds the base.
constexpr std::uint8_t kUsbRequestTypeOut = 0x40;  // bmRequestType: host to device, vendor, device
constexpr std::uint8_t kUsbRequestTypeIn = 0xC0;   // device to host, vendor, device
enum class UsbRequest : std::uint8_t {
  kEstop = 1,      // OUT, no data, wValue: reason. Same as an ESTOP frame
  kHello = 2,      // IN: one whole HELLO frame
  kMsOs20 = 0x20,  // IN: descriptor set of Microsoft OS 2.0, wIndex 7
  kWebUsb = 0x21,  // IN: WebUSB URL, wIndex 2
};

}  // namespace omni::wire
