// A run as an SVG picture: the tip's path in side and top view with contacts, force and inputs over time.
#pragma once

#include <string>

#include "service/haptics/scene/scene.h"
#include "service/tools/recordings/report.h"

namespace omni::tools {

// `scene` may be empty: then only the hull and the path are drawn.
std::string DrawRun(const RunReport& report, const RunData& data, const haptics::Scene& scene, double hull_radius_m);

}  // namespace omni::tools
