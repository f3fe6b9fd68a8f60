// The texts of manifests/device/omni.toml, twin.toml and marks.toml, put into the binary by CMake.
#pragma once

namespace omni::config {

extern const char* const kBuiltInDeviceText;
extern const char* const kBuiltInTwinText;
extern const char* const kBuiltInMarksText;

}  // namespace omni::config
