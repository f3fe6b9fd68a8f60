// Summary of a device recording, as text and as JSON.
#pragma once

#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/device/recording/recording_reader.h"

namespace omni::tools {

// Several lines, each with its newline.
std::string RecordingText(const std::string& path, const device::RecordingSummary& summary);
nlohmann::ordered_json RecordingJson(const std::string& path, const device::RecordingSummary& summary);

}  // namespace omni::tools
