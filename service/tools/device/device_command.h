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

// All return an exit status (command_line.h); errors go to stderr as one line.

int DeviceList(device::UsbBus& bus, std::ostream& out);

// Who else may have the base, and the status of the service if it is that; of this machine, and in tests of another
// one.
struct OtherPrograms {
  std::function<std::vector<device::Holder>(const std::string& node)> holders;
  std::function<base::Result<nlohmann::json>()> service_status;
};
OtherPrograms ThoseOfThisMachine();

// `serial` empty: the only base there is. Of a base that omnid holds, what omnid knows.
int DeviceInfo(device::UsbBus& bus, const std::string& serial, std::ostream& out,
               const OtherPrograms& others = ThoseOfThisMachine());

// `agreed` is asked before anything is done to the base; false ends it.
int DeviceSelfTest(device::UsbBus& bus, const std::string& serial, const std::function<bool()>& agreed,
                   std::ostream& out);

// `serial` empty: every base. In an emergency nobody is asked which one.
int DeviceEstop(device::UsbBus& bus, const std::string& serial, std::ostream& out);

}  // namespace omni::tools
