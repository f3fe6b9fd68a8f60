#include "service/sim/coils/hall_array.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/wire/messages.h"
#include "service/base/limits.h"

namespace omni::sim {

HallArray::HallArray(const base::DeviceGeometry& device, const base::SensorParameters& sensor_parameters,
                     std::int64_t start_ns, Random& random)
    : noise_T_(device.sensor_noise_T),
      lsb_T_(device.sensor_lsb_T),
      full_scale_(wire::ToCounts<std::uint16_t>(
          std::min(device.sensor_range_T, device.sensor_lsb_T * std::numeric_limits<std::int16_t>::max()),
          device.sensor_lsb_T)) {
  for (std::size_t i = 0; i < kFlickerTimes_s.size(); ++i) {
    const double keep = flicker_keep_[i] = std::exp(-base::kTickPeriod_s / kFlickerTimes_s[i]);
    flicker_new_T_[i] = std::sqrt(1 - keep * keep) * sensor_parameters.flicker_T;
  }
  const double spread = sensor_parameters.oscillator_spread;
  for (Sensor& sensor : sensors_) {
    sensor.period_ns = std::llround(base::kTickPeriod_ns * (1 + random.Uniform(-spread, spread)));
    sensor.next_ns = start_ns + std::llround(static_cast<double>(sensor.period_ns) * random.Uniform());
  }
}

bool HallArray::NextSample(std::size_t index, std::int64_t t_ns, std::int64_t& sample_ns) noexcept {
  Sensor& sensor = sensors_[index];
  sensor.fresh = false;
  bool any = false;
  while (sensor.next_ns <= t_ns) {
    sample_ns = sensor.next_ns;
    sensor.next_ns += sensor.period_ns;
    any = true;
  }
  return any;
}

// Processes of first order of equal strength, one a decade: together 1/f between the times of the fastest and slowest
// [van der Ziel 1950].
double HallArray::Flicker_T(Sensor& sensor, std::size_t axis, Random& random) const noexcept {
  if (!(flicker_new_T_[0] > 0)) return 0;
  double sum_T = 0;
  for (std::size_t i = 0; i < kFlickerTimes_s.size(); ++i) {
    double& process_T = sensor.flicker_T[axis][i];
    process_T = flicker_keep_[i] * process_T + flicker_new_T_[i] * random.Normal();
    sum_T += process_T;
  }
  return sum_T;
}

void HallArray::RepeatSample(std::size_t index, std::int64_t sample_ns) noexcept {
  sensors_[index].fresh = true;
  sensors_[index].sampled_ns = sample_ns;
}

void HallArray::TakeSample(std::size_t index, std::int64_t sample_ns, const Vec3& reading_T, Random& random) noexcept {
  Sensor& sensor = sensors_[index];
  const std::array<double, 3> reading{reading_T.x, reading_T.y, reading_T.z};
  const double full_scale_T = full_scale_ * lsb_T_;
  sensor.fresh = true;
  sensor.sampled_ns = sample_ns;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double noisy_T = reading[axis] + noise_T_[axis] * random.Normal() + Flicker_T(sensor, axis, random);
    sensor.counts[axis] = wire::ToCounts<std::int16_t>(std::clamp(noisy_T, -full_scale_T, full_scale_T), lsb_T_);
  }
}

}  // namespace omni::sim
