// The subcommands of `omni device` on any bus; device_command.cc adds them to the command line.
#pragma once

#include <functional>
#include <iosfwd>
#include <string>

#include "service/device/usb_bus.h"

namespace omni::tools {

// All return an exit status (command_line.h); errors go to stderr as one line.

int DeviceList(device::UsbBus& bus, std::ostream& out);

// `serial` empty: the only base there is.
int DeviceInfo(device::UsbBus& bus, const std::string& serial, std::ostream& out);

// `agreed` is asked before anything is done to the base; false ends it.
int DeviceSelfTest(device::UsbBus& bus, const std::string& serial, const std::function<bool()>& agreed,
                   std::ostream& out);

// `serial` empty: every base. In an emergency nobody is asked which one.
int DeviceEstop(device::UsbBus& bus, const std::string& serial, std::ostream& out);

}  // namespace omni::tools
