// Device files of any sensor array: 4 to 64 sensors anywhere, a cylinder or sphere magnet, with or without core, hull
// and coils. Format and units: docs/howto/track.md. Errors name file, line, key, value and allowed range.
#pragma once

#include <string>
#include <vector>

#include "service/base/device_geometry.h"
#include "service/base/result.h"

namespace omni::config {

// The content of a file. What follows from it by a formula is left to magnetics (nominal.h): the moment if the file has
// a remanence (then calibration.moment_Am2 is 0), the current maps if it has windings (`coils` holds three).
struct ArrayFile {
  base::Calibration calibration;
  std::vector<base::CoilGeometry> coils;  // none or kCoilCount; turns, layers, radii, band and axis only
};

// True: the text names an array format (`format = "..."`). Device files of Omni bases do not (device_file.h).
bool IsArrayText(const std::string& text);

// `name` stands for the file in messages.
base::Result<ArrayFile> ParseArray(const std::string& text, const std::string& name);

// Text that ParseArray reads back as the same numbers. Writes current maps, not coils.
std::string WriteArray(const base::Calibration& calibration);

}  // namespace omni::config
