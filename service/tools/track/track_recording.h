// A recording of an array: readings pose by pose, and the true pose where it was measured.
// Formats: docs/howto/track.md.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "service/base/calibration.h"
#include "service/base/result.h"

namespace omni::tools {

// No magnet of the allowed kind makes more at a sensor outside it; uT written as T does.
constexpr double kFieldMax_T = 2;

struct RecordedPose {
  std::size_t number = 0;                  // as in the file
  std::vector<base::Vec3> field_sensor_T;  // by sensor, background included
  std::array<double, base::kCoilCount> current_A{};
};

struct Recording {
  std::vector<RecordedPose> poses;  // in the file's order
  bool has_currents = false;
};

struct TruePose {
  base::Vec3 position_base_m;
  base::Vec3 axis_base;  // unit, along the moment
};
using Truth = std::map<std::size_t, TruePose>;  // by number

// pose, sensor, bx_U, by_U, bz_U (U: T, mT, uT, G or mG); optional i0_A, i1_A, i2_A. Every pose has every one of the
// `array`'s sensors once.
base::Result<Recording> ReadRecording(const std::string& path, const base::Calibration& array);

// pose, x_U, y_U, z_U (U: m or mm), ux, uy, uz.
base::Result<Truth> ReadTruth(const std::string& path);

std::string WriteRecording(const Recording& recording);
std::string WriteTruth(const Truth& truth);

}  // namespace omni::tools
