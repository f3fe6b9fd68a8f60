// What `omni device` prints about a base.
#pragma once

#include <string>
#include <vector>

#include "service/device/usb/usb_bus.h"
#include "service/device/usb/usb_holders.h"
#include "service/device/usb/usb_probe.h"

namespace omni::tools {

struct ListedBase {
  device::UsbBase base;
  std::string firmware;  // "0.1"; empty: it did not say
  std::vector<device::Holder> holders;
};
// "0.1"
std::string FirmwareText(std::uint16_t version);
std::string DeviceListText(const std::vector<ListedBase>& bases);

// Who it is and what it can do.
std::string DeviceIdentityText(const device::UsbBase& base, const wire::Hello& hello);
// What it measures right now, its faults with advice, and the one it kept across its last reset.
std::string DeviceLiveText(const device::UsbProbe& probe);

// One finding of `omni device selftest`.
struct SelfTestRow {
  std::string name;
  bool passed = false;
  std::string text;
};
std::vector<SelfTestRow> JudgeSelfTest(const device::UsbProbe& probe);
std::string SelfTestText(const std::vector<SelfTestRow>& rows);

std::string FlashHelpText();

}  // namespace omni::tools
