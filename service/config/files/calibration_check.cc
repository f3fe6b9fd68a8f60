#include "service/config/files/calibration_check.h"

#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <utility>

namespace omni::config {
namespace {

using base::SensorCalibration;
using base::Vec3;
using Matrix = std::array<double, 9>;  // row-major

constexpr const char* kAxes = "xyz";
constexpr const char* kMeasureTip =
    "if this is another pen, delete this line and the checksum line, then: omni calibrate --tip";

template <class... Arguments>
std::string Format(const char* format, Arguments... arguments) {
  char text[160];
  std::snprintf(text, sizeof text, format, arguments...);
  return text;
}

Vec3 Row(const Matrix& m, std::size_t i) { return {m[3 * i], m[3 * i + 1], m[3 * i + 2]}; }
Vec3 Column(const Matrix& m, std::size_t i) { return {m[i], m[3 + i], m[6 + i]}; }

double Determinant(const Matrix& m) {
  return m[0] * (m[4] * m[8] - m[5] * m[7]) - m[1] * (m[3] * m[8] - m[5] * m[6]) + m[2] * (m[3] * m[7] - m[4] * m[6]);
}

// Rows of a gain are the sensor's axes in frame B, as long as each is sensitive.
std::string GainProblem(const Matrix& drawn, const Matrix& found) {
  if (const double determinant = Determinant(found); !(determinant > 0)) {
    return Format("mirrors the field (its determinant is %.3g, must be above 0)", determinant);
  }
  for (std::size_t i = 0; i < 3; ++i) {
    const Vec3 was = Row(drawn, i), is = Row(found, i);
    const double scale = Norm(is) / Norm(was);
    if (!(scale >= kScaleMin && scale <= kScaleMax)) {
      return Format("has axis %c at %.3g of the drawing, must be in [%g, %g]", kAxes[i], scale, kScaleMin, kScaleMax);
    }
    const double turned_deg = std::acos(std::fmin(1, Dot(was, is) / (Norm(was) * Norm(is)))) * 180 / std::numbers::pi;
    if (!(turned_deg <= kTurnedMax_deg)) {
      return Format("has axis %c %.1f degrees away from the drawing, the limit is %g", kAxes[i], turned_deg,
                    kTurnedMax_deg);
    }
  }
  return {};
}

// Columns of a current map are the coils' fields at the sensor; steel under the base adds its answer to them.
std::string MapProblem(const Matrix& drawn, const Matrix& found, double steel_strength) {
  const double across_max = kCoilAcrossMax + kSteelAcross * std::fmin(1, std::fabs(steel_strength));
  for (std::size_t k = 0; k < 3; ++k) {
    const Vec3 was = Column(drawn, k), is = Column(found, k);
    const double size = Norm(was);
    if (!(size > 0)) continue;
    const double along = Dot(was, is) / (size * size);
    if (!(along >= kCoilScaleMin && along <= kCoilScaleMax)) {
      return Format("has coil %c at %.3g of the drawing, must be in [%g, %g]", kAxes[k], along, kCoilScaleMin,
                    kCoilScaleMax);
    }
    const double across = Norm(is - along * was) / size;
    if (!(across <= across_max)) {
      return Format("has %.3g of coil %c across the drawing's field, the limit is %g", across, kAxes[k], across_max);
    }
  }
  return {};
}

std::string PlaceProblem(const Vec3& drawn, const Vec3& found) {
  const double moved_m = Distance(found, drawn);
  if (moved_m <= kMovedMax_m) return {};
  return Format("is %.1f mm from the drawing, the limit is %g mm", 1e3 * moved_m, 1e3 * kMovedMax_m);
}

std::string BackgroundProblem(const Vec3& found) {
  if (const double size_T = Norm(found); !(size_T <= kBackgroundMax_T)) {
    return Format("is %.0f uT strong, the limit is %.0f: a magnet was near", 1e6 * size_T, 1e6 * kBackgroundMax_T);
  }
  return {};
}

std::optional<ImplausibleValue> FindInSensor(int index, const SensorCalibration& drawn, const SensorCalibration& found,
                                             double steel_strength) {
  const std::pair<const char*, std::string> problems[] = {
      {"position_base_m", PlaceProblem(drawn.position_base_m, found.position_base_m)},
      {"gain_sensor_base", GainProblem(drawn.gain_sensor_base, found.gain_sensor_base)},
      {"current_map_T_A", MapProblem(drawn.current_map_T_A, found.current_map_T_A, steel_strength)},
      {"background_sensor_T", BackgroundProblem(found.background_sensor_T)}};
  for (const auto& [key, what] : problems) {
    if (!what.empty()) return ImplausibleValue{index, "sensors", key, what};
  }
  return std::nullopt;
}

}  // namespace

std::optional<ImplausibleValue> FindImplausible(const base::Calibration& drawing, const base::Calibration& found) {
  const double ratio = found.moment_Am2 / drawing.moment_Am2;
  if (!(ratio >= kScaleMin && ratio <= kScaleMax)) {
    return ImplausibleValue{
        -1, "magnet", "moment_Am2",
        Format("is %.3g of the drawing's %.3g, must be in [%g, %g]", ratio, drawing.moment_Am2, kScaleMin, kScaleMax)};
  }
  if (const double off = std::abs(found.core_kappa - drawing.core_kappa); !(off <= kKappaMax)) {
    return ImplausibleValue{
        -1, "magnet", "core_kappa",
        Format("is %.3g from the drawing's %.3g, the limit is %g", off, drawing.core_kappa, kKappaMax)};
  }
  const double tip_m = found.magnet.tip_offset_m - drawing.magnet.tip_offset_m;
  if (!(std::abs(tip_m) <= kTipMax_m)) {
    return ImplausibleValue{-1, "magnet", "tip_offset_m",
                            Format("is %+.1f mm from the drawing's, the limit is %g mm", 1e3 * tip_m, 1e3 * kTipMax_m),
                            kMeasureTip};
  }
  if (const double off_m = std::abs(found.hull_radius_m - drawing.hull_radius_m); !(off_m <= kSizeMax_m)) {
    return ImplausibleValue{-1, "base", "hull_radius_m",
                            Format("is %.1f mm from the drawing's, the limit is %g mm", 1e3 * off_m, 1e3 * kSizeMax_m)};
  }
  if (const double off_m = Norm(found.core_centre_base_m); !(off_m <= kSizeMax_m)) {
    return ImplausibleValue{-1, "base", "core_centre_base_m",
                            Format("is %.1f mm from the hull's, the limit is %g mm", 1e3 * off_m, 1e3 * kSizeMax_m)};
  }
  for (std::size_t i = 0; i < found.sensors.size(); ++i) {
    auto value = FindInSensor(static_cast<int>(i), drawing.sensors[i], found.sensors[i], found.steel.strength);
    if (value) return value;
  }
  return std::nullopt;
}

}  // namespace omni::config
