// A race as it was driven, from the service's recording (omnid --record): the car's path lap by lap, and its hits.
#pragma once

#include <string>
#include <vector>

#include "scenes/generator/pictures/picture.h"

namespace omni::scenes {

struct RacePoint {
  double t_s = 0;
  double x_m = 0, y_m = 0, heading_rad = 0;
  unsigned hits = 0, laps = 0;
  double last_lap_s = 0;
};

// Throws std::runtime_error: not there, columns missing, or no car in it.
std::vector<RacePoint> ReadRace(const std::string& path);

// Lines over the road at `height_m`, one colour per lap, a star at every hit, and the car where it ended.
std::vector<DrawnMesh> DrawRace(const std::vector<RacePoint>& race, double height_m);

// "2 laps: 5.02 s (blue), 4.71 s (green); 7 hits (red stars)"
std::string RaceCaption(const std::vector<RacePoint>& race);

}  // namespace omni::scenes
