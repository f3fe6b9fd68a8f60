// manifests/device/*.toml -> DeviceGeometry. Errors name the file, the key, the value and the allowed range.
#pragma once

#include <string>

#include "service/base/device_geometry.h"
#include "service/base/result.h"

namespace omni::config {

inline constexpr double kTipOffsetMax_m = 0.2;  // of any pen, drawn or measured

base::Result<base::DeviceGeometry> LoadDeviceFile(const std::string& path);

// `name` stands for the file in messages.
base::Result<base::DeviceGeometry> ParseDevice(const std::string& text, const std::string& name);

// The geometry built into the binary: the same numbers as manifests/device/omni.toml (embedded at build).
const base::DeviceGeometry& DefaultDevice();

}  // namespace omni::config
