// What forces a device can make, as reported to applications.
#pragma once

#include "service/base/device_geometry.h"
#include "service/loop/tick.h"
#include "service/protocol/force_feedback.h"

namespace omni::daemon {

// Off the tick: some thousand evaluations of the force map.
protocol::ForceProperties DescribeForce(const loop::TickConfig& config, const base::DeviceGeometry& device);

}  // namespace omni::daemon
