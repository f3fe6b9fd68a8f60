// One scan: all Hall readings of a device tick, with the coil currents measured at the same time.
// Coil currents disturb the Hall sensors; carrying them here keeps the pipeline free of a back edge
// (the tracker subtracts their field using data from the scan itself).
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <type_traits>

#include "service/base/limits.h"
#include "service/base/vec.h"

namespace omni::base {

inline constexpr std::int64_t kSampleAgeMax_ns = 5'000'000;  // older samples are discarded

struct HallScan {
  std::int64_t t_ns = 0;       // CLOCK_MONOTONIC of the newest Hall sample of this scan
  std::uint64_t sequence = 0;  // device tick counter
  // Calibrated flux density in each sensor's own frame S, tesla. Not finite = unusable.
  std::array<Vec3, kSensorCount> field_sensor_T{};
  std::array<std::int64_t, kSensorCount> age_ns{};  // t_ns - (time of that sensor's sample), >= 0
  std::uint32_t fresh_mask = 0;                     // bit i: sensor i has a new sample since the last scan
  std::uint32_t saturated_mask = 0;                 // bit 3 i + axis: that axis is at its limit
  std::array<double, kCoilCount> coil_current_A{};  // measured, mean over the tick
  // The same at the ends of the tick's control steps, evenly spaced, oldest first; the last at the tick's end, which is
  // `tick_lead_ns` after t_ns. Only where has_steps is not 0.
  std::array<std::array<double, kCoilCount>, kStepsPerTick> step_current_A{};
  std::int64_t tick_lead_ns = 0;
  // From a scan's stamp to the control step at which the set-points computed from it take effect, as measured at the
  // base: about one response in a hundred comes later. 0: not known.
  std::int64_t response_ns = 0;
  std::array<double, kCoilCount> coil_temperature_C{};  // estimated by the device
  double supply_V = 0;
  std::uint32_t has_steps = 0;
  std::uint32_t device_faults = 0;  // wire::Fault bits; != 0 means the device holds its coils at zero
};
static_assert(std::is_trivially_copyable_v<HallScan>);

inline bool IsFreshSample(const HallScan& scan, std::size_t sensor) noexcept {
  return scan.age_ns[sensor] >= 0 && scan.age_ns[sensor] <= kSampleAgeMax_ns;
}
inline bool IsSilentSensor(const HallScan& scan, std::size_t sensor) noexcept {
  const Vec3& B = scan.field_sensor_T[sensor];
  return !std::isfinite(B.x + B.y + B.z) || !IsFreshSample(scan, sensor);
}

}  // namespace omni::base
