// One [[sensors]] table of an array file. Private to this folder.
#pragma once

#include "service/base/calibration.h"
#include "service/config/text/toml_reader.h"

namespace omni::config {

// How the sensor stands: orientation_base_sensor (quaternion w, x, y, z), rotation_base_sensor_rad (rotation vector) or
// gain_sensor_base (the whole 3x3 map, gain included); none of them: aligned with B. `gain`: a number, three (one per
// axis) or nine (row-major, applied in the sensor's frame).
base::SensorCalibration ReadArraySensor(FileProblem& problem, TableReader& reader);

}  // namespace omni::config
