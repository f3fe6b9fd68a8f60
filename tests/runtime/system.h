#pragma once
// Facts about the one system that sessions and frames need.

#include <openxr/openxr.h>

namespace omni::runtime {

inline constexpr XrSystemId kSystemId = 1;
inline constexpr uint32_t kEyes = 2;
inline constexpr uint32_t kEyeWidth = 1024;
inline constexpr uint32_t kEyeHeight = 1024;

XrResult CheckViewConfiguration(XrViewConfigurationType type);
bool IsSupportedBlendMode(XrEnvironmentBlendMode mode);

}  // namespace omni::runtime
