// Any device file as what the tracker needs: an array file, or the geometry of an Omni base.
#pragma once

#include <string>

#include "service/base/calibration.h"
#include "service/base/result.h"

namespace omni::tools {

base::Result<base::Calibration> LoadTrackDevice(const std::string& path);

}  // namespace omni::tools
