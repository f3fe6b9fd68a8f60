// What a person at the pen perceives through an application. Everything comes from what omnid publishes to clients,
// nothing from the simulation.
#pragma once

#include <cstdint>

#include "service/base/vec.h"

namespace omni::tools {

struct PerceivedCar {
  bool on = false;  // there is one
  base::Vec3 position_base_m;
  double heading_rad = 0;
  double speed_m_s = 0;
  std::uint32_t laps = 0, hits = 0;
};

struct Perceived {
  double t_s = 0;  // the person's clock
  bool pen = false;
  base::Vec3 tip_base_m;
  double press_N = 0;                // of the tip on what it touches
  std::uint32_t select_presses = 0;  // so far
  PerceivedCar car;
  bool soft = false;  // a soft body is drawn ...
  double dent_m = 0;  // ... with this largest displacement
  bool clay = false;  // something can be sculpted ...
  std::uint32_t strokes = 0;
  bool stroke_open = false;
};

}  // namespace omni::tools
