// Summary of a device recording as text.
#pragma once

#include <string>

#include "service/device/recording/recording_reader.h"

namespace omni::tools {

// Several lines, each with its newline.
std::string RecordingText(const std::string& path, const device::RecordingSummary& summary);

}  // namespace omni::tools
