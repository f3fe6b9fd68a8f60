// manifests/device: DeviceGeometry, and marks.toml. Errors name the file, the key, the value and the allowed range.
#pragma once

#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"
#include "service/base/vec.h"

namespace omni::config {

inline constexpr double kTipOffsetMax_m = 0.2;  // of any pen, drawn or measured

base::Result<base::DeviceGeometry> LoadDeviceFile(const std::string& path);

// `name` stands for the file in messages.
base::Result<base::DeviceGeometry> ParseDevice(const std::string& text, const std::string& name);

// The geometry built into the binary: the same numbers as manifests/device/omni.toml (embedded at build).
const base::DeviceGeometry& DefaultDevice();

// Radius of the pen's nib, half a ball before the magnet's face whose foremost point is the device point
// (docs/drawings/pen.svg). 0, a point: of a bare magnet, and of a longer rod, whose end no file describes.
double NibRadius_m(const base::MagnetGeometry& magnet);

// manifests/device/marks.toml: points of the base that a controller can touch.
inline constexpr std::size_t kMinMarks = 3;
inline constexpr std::size_t kMaxMarks = 12;

struct Mark {
  std::string name;
  base::Vec3 position_base_m;
};

base::Result<std::vector<Mark>> LoadMarksFile(const std::string& path);
// `name` stands for the file in messages.
base::Result<std::vector<Mark>> ParseMarks(const std::string& text, const std::string& name);
// Those built into the binary.
const std::vector<Mark>& DefaultMarks();

}  // namespace omni::config
