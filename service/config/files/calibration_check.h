// Whether a calibration is plausible for this device: its numbers are compared with the drawing. Ranges of single
// numbers cannot show: with every gain negated a pen is tracked as well, but pushed the wrong way.
//
// Every limit is about twice what `omni calibrate` itself accepts, which is five manufacturing tolerances per parameter
// (service/calibration/types.h: 1 mm, 1.15 degrees, 1.5 % of a sensor, 15 % of a magnet).
#pragma once

#include <optional>
#include <string>

#include "service/base/device_geometry.h"

namespace omni::config {

inline constexpr double kTurnedMax_deg = 20;   // a sensor's axis from the drawing: 5.7 degrees about each axis pass
inline constexpr double kScaleMin = 0.7;       // of a sensor's axis and of the magnet
inline constexpr double kScaleMax = 1.3;       //
inline constexpr double kMovedMax_m = 0.01;    // a sensor's place: 5 mm along each axis pass
inline constexpr double kCoilScaleMin = 0.7;   // of a coil's field along the drawing's: what calibration allows itself
inline constexpr double kCoilScaleMax = 1.4;   //
inline constexpr double kCoilAcrossMax = 0.5;  // share of a coil's field across the drawing's: turned by 27 degrees
inline constexpr double kSteelAcross = 0.25;   // more of it beside a steel plane of strength 1, at 115 mm
inline constexpr double kKappaMax = 0.1;       // from the drawing: ten tolerances
inline constexpr double kSizeMax_m = 3e-3;     // of hull and core's place: ten tolerances
inline constexpr double kTipMax_m = 0.01;      // of the pen's tip: ten tolerances
inline constexpr double kBackgroundMax_T = 3e-4;  // four times the earth's field: a magnet was near

struct ImplausibleValue {
  int sensor = -1;                // index; -1: the value belongs to `table`
  const char* table = "sensors";  // of the file
  const char* key = "";
  std::string what;  // "axis y points 41.0 degrees away from the drawing, the limit is 20"
  const char* remedy = "no base of this design can be like that; measure this base: omni calibrate --replace";
};

// The first one found; none: plausible. Precondition: as many sensors as the drawing.
std::optional<ImplausibleValue> FindImplausible(const base::Calibration& drawing, const base::Calibration& found);

}  // namespace omni::config
