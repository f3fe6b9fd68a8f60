// The subcommands of `omni device` on any bus; device_command.cc adds them to the command line.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/device/usb/usb_bus.h"
#include "service/device/usb/usb_holders.h"

namespace omni::tools {

// All return an exit status (command_line.h); errors go to stderr as one line. `as_json`: `out` gets JSON
// (device_json.h), also of an error.

int DeviceList(device::UsbBus& bus, bool as_json, std::ostream& out);

// Which programs hold the base, and the service's status; fabricated in tests.
struct OtherPrograms {
  std::function<std::vector<device::Holder>(const std::string& node)> holders;
  std::function<base::Result<nlohmann::json>()> service_status;
};
OtherPrograms ThoseOfThisMachine();

// `serial` empty: the only base there is. If omnid holds the base, shows what omnid knows.
int DeviceInfo(device::UsbBus& bus, const std::string& serial, bool as_json, std::ostream& out,
               const OtherPrograms& others = ThoseOfThisMachine());

// `agreed` is called before anything is done to the base; false cancels.
int DeviceSelfTest(device::UsbBus& bus, const std::string& serial, const std::function<bool()>& agreed, bool as_json,
                   std::ostream& out);

// `serial` empty: every base, because an emergency stop must not ask which one.
int DeviceEstop(device::UsbBus& bus, const std::string& serial, std::ostream& out);

}  // namespace omni::tools
