// Whether the numbers of a device fit together: what single ranges cannot show.
#pragma once

#include <string>

#include "service/base/device_geometry.h"

namespace omni::config {

// The first contradiction, with the keys and values involved and what must hold; empty: none.
std::string GeometryProblem(const base::DeviceGeometry& device);

}  // namespace omni::config
