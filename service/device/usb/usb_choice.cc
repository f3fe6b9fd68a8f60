// Selects a base by serial, with an error message when the choice is not clear.
#include <utility>

#include "service/device/usb/usb_bus.h"

namespace omni::device {
namespace {

std::string Listed(const std::vector<UsbBase>& bases) {
  std::string text;
  for (const UsbBase& base : bases) {
    text +=
        (text.empty() ? "" : ", ") + (base.serial.empty() ? "one without a serial at port " + base.port : base.serial);
  }
  return text;
}

}  // namespace

std::string UsbBaseName(const UsbBase& base) {
  return "usb base " + (base.serial.empty() ? "at port " + base.port : base.serial);
}

std::string UsbPermissionHelp(const std::string& node) {
  return "no permission for " + node +
         ": install manifests/udev/70-omni.rules as /etc/udev/rules.d/70-omni.rules, then run `sudo udevadm control "
         "--reload && sudo udevadm trigger --subsystem-match=usb` or plug the base in again";
}

base::Result<UsbBase> ChooseUsbBase(const std::vector<UsbBase>& bases, const std::string& serial) {
  if (bases.empty()) {
    return base::Error{"no Omni base on USB" + (serial.empty() ? std::string() : " (looked for " + serial + ")") +
                       ": connect it and switch its supply on; `omni device list` shows what is there"};
  }
  std::vector<UsbBase> matching;
  for (const UsbBase& base : bases) {
    if (serial.empty() || base.serial == serial) matching.push_back(base);
  }
  if (matching.size() == 1) return std::move(matching.front());
  if (matching.empty()) {
    return base::Error{"no Omni base with serial " + serial + " on USB; there is: " + Listed(bases)};
  }
  if (serial.empty()) {
    return base::Error{std::to_string(bases.size()) + " Omni bases on USB: " + Listed(bases) +
                       "; choose one: omnid --device usb:SERIAL, omni device ... SERIAL"};
  }
  return base::Error{std::to_string(matching.size()) + " Omni bases on USB have the serial " + serial +
                     "; disconnect all but one"};
}

}  // namespace omni::device
