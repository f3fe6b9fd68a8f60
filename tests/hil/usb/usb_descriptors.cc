#include "tests/hil/usb/usb_descriptors.h"

#include "firmware/drivers/usb_descriptors.h"
#include "firmware/wire/usb_ids.h"

namespace omni::hil {
namespace {

namespace usb = drivers::usb;

static_assert(usb::kVendorId == wire::kUsbVendorId && usb::kProductId == wire::kUsbProductId, "one name on the bus");

template <class Bytes>
std::vector<std::uint8_t> ToVector(const Bytes& bytes) {
  return {bytes.begin(), bytes.end()};
}

std::vector<std::uint8_t> String(std::uint8_t index, const std::string& serial) {
  if (index == usb::kStringLanguages) return ToVector(usb::kLanguages);
  if (index == usb::kStringManufacturer) return ToVector(usb::kManufacturer);
  if (index == usb::kStringProduct) return ToVector(usb::kProduct);
  if (index != usb::kStringSerial || serial.empty()) return {};
  std::vector<std::uint8_t> bytes{static_cast<std::uint8_t>(2 + 2 * serial.size()), usb::kDescriptorString};
  for (const char c : serial) {
    bytes.push_back(static_cast<std::uint8_t>(c));
    bytes.push_back(0);
  }
  return bytes;
}

}  // namespace

std::vector<std::uint8_t> SysfsDescriptors() {
  return ToVector(usb::Concatenate(usb::kDevice, usb::kConfigurationHigh));
}

std::vector<std::uint8_t> Descriptor(std::uint16_t value, const std::string& serial) {
  switch (usb::HighByte(value)) {
    case usb::kDescriptorDevice:
      return ToVector(usb::kDevice);
    case usb::kDescriptorConfiguration:
      return ToVector(usb::kConfigurationHigh);
    case usb::kDescriptorString:
      return String(usb::LowByte(value), serial);
    case usb::kDescriptorQualifier:
      return ToVector(usb::kQualifier);
    case usb::kDescriptorOtherSpeed:
      return ToVector(usb::kOtherSpeedOfHigh);
    case usb::kDescriptorBos:
      return ToVector(usb::kBos);
    default:
      return {};
  }
}

std::vector<std::uint8_t> MsOsDescriptors() { return ToVector(usb::kMsOs); }

}  // namespace omni::hil
