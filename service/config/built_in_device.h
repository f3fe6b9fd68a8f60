// The text of manifests/device/omni.toml, put into the binary by CMake.
#pragma once

namespace omni::config {

extern const char* const kBuiltInDeviceText;

}  // namespace omni::config
