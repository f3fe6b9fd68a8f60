// Owners of libusb's objects, and its errors as text. Only libusb_*.cc include this.
#pragma once

#include <libusb.h>

#include <memory>
#include <string>

#include "service/device/usb/usb_bus.h"

namespace omni::device {

using LibusbContext = std::shared_ptr<libusb_context>;

struct LibusbClose {
  void operator()(libusb_device_handle* handle) const noexcept { libusb_close(handle); }
};
using LibusbHandle = std::unique_ptr<libusb_device_handle, LibusbClose>;

// What went wrong ("cannot `what`") with the node, and what to do about it.
std::string LibusbProblem(int error, const std::string& what, const std::string& node);

// Claims the vendor interface of an opened base and finds its endpoints; see libusb_link.cc.
base::Result<std::unique_ptr<UsbLink>> MakeLibusbLink(LibusbContext context, LibusbHandle handle,
                                                      const std::string& node, bool realtime);

}  // namespace omni::device
