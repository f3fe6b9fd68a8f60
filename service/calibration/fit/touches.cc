#include "service/calibration/fit/touches.h"

#include <cmath>

namespace omni::calibration {
namespace {

// |a - b| / |a| over the axes that both have.
double RelativeChange(const std::vector<base::Vec3>& a, const std::vector<base::Vec3>& b) {
  double change = 0, size = 0;
  const auto add = [&](double x, double y) {
    if (!(std::isfinite(x) && std::isfinite(y))) return;
    change += (x - y) * (x - y);
    size += x * x;
  };
  for (std::size_t i = 0; i < a.size(); ++i) {
    add(a[i].x, b[i].x);
    add(a[i].y, b[i].y);
    add(a[i].z, b[i].z);
  }
  return size > 0 ? std::sqrt(change / size) : 0.0;
}

}  // namespace

std::optional<Sample> TouchPicker::Add(const WindowResult& window) {
  if (!window.still) {
    resting_ = 0;
    return {};
  }
  if (++resting_ < options_.windows_min) return {};
  const std::vector<base::Vec3>& field = window.sample.field_sensor_T;
  if (!last_sensor_T_.empty() && RelativeChange(field, last_sensor_T_) < options_.apart_relative) return {};
  last_sensor_T_ = field;
  Sample touch = window.sample;
  touch.touches_hull = true;
  return touch;
}

}  // namespace omni::calibration
