// What `omni device` prints about a base.
#pragma once

#include <string>
#include <vector>

#include "service/device/usb/usb_bus.h"
#include "service/device/usb/usb_holders.h"
#include "service/device/usb/usb_probe.h"

namespace omni::tools {

inline constexpr double kResistanceUnit_ohm = 1e-4;  // of wire::Telemetry

struct ListedBase {
  device::UsbBase base;
  std::string firmware;  // "0.1"; empty: unknown
  std::vector<device::Holder> holders;
};
// "0.1"
std::string FirmwareText(std::uint16_t version);
std::string DeviceListText(const std::vector<ListedBase>& bases);

// Its identity and capabilities.
std::string DeviceIdentityText(const device::UsbBase& base, const wire::Hello& hello);
// Its current measurements, its faults with advice, and the fault kept across its last reset.
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
