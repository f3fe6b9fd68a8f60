// The texts of manifests/device/omni.toml and twin.toml, put into the binary by CMake.
#pragma once

namespace omni::config {

extern const char* const kBuiltInDeviceText;
extern const char* const kBuiltInTwinText;

}  // namespace omni::config
