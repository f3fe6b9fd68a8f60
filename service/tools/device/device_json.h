// What `omni device --json` prints about a base: the same facts as device_text.h, SI units.
#pragma once

#include <vector>

#include <nlohmann/json_fwd.hpp>

#include "service/tools/device/device_text.h"

namespace omni::tools {

// An array, one object per base.
nlohmann::ordered_json DeviceListJson(const std::vector<ListedBase>& bases);

// Its identity and capabilities.
nlohmann::ordered_json DeviceIdentityJson(const device::UsbBase& base, const wire::Hello& hello);

// Its current measurements, its faults with advice, and the fault kept across its last reset.
nlohmann::ordered_json DeviceLiveJson(const device::UsbProbe& probe);

nlohmann::ordered_json HoldersJson(const std::vector<device::Holder>& holders);

nlohmann::ordered_json SelfTestJson(const std::vector<SelfTestRow>& rows);

}  // namespace omni::tools
