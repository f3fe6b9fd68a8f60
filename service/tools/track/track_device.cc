#include "service/tools/track/track_device.h"

#include "service/config/files/array_file.h"
#include "service/config/files/device_file.h"
#include "service/config/text/text_file.h"
#include "service/magnetics/nominal.h"

namespace omni::tools {

base::Result<base::Calibration> LoadTrackDevice(const std::string& path) {
  const auto text = config::ReadTextFile(path);
  if (!text.ok()) return base::Error{text.error()};
  if (!config::IsArrayText(*text)) {
    const auto device = config::ParseDevice(*text, path);
    if (!device.ok()) {
      return base::Error{
          device.error() +
          " (read as the device file of an Omni base; other arrays start with format = \"omni-array 1\")"};
    }
    return magnetics::NominalCalibration(*device);
  }
  auto file = config::ParseArray(*text, path);
  if (!file.ok()) return base::Error{file.error()};
  base::Calibration array = std::move(file->calibration);
  if (!(array.moment_Am2 > 0)) array.moment_Am2 = magnetics::MomentOf(array.magnet);
  magnetics::AddWindings(file->coils, array);
  return array;
}

}  // namespace omni::tools
