// What `omni device info` prints about a base that another program holds.
#pragma once

#include <string>
#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"
#include "service/device/usb/usb_bus.h"
#include "service/device/usb/usb_holders.h"

namespace omni::tools {

std::string DeviceHeldText(const std::vector<device::Holder>& holders);

// What omnid knows of `base`: state, faults with advice; or why that is not available. `status`: of FetchStatus.
std::string DeviceServedText(const base::Result<nlohmann::json>& status, const device::UsbBase& base);

// What to do to see the rest.
std::string DeviceFreeItText(bool is_service);

}  // namespace omni::tools
