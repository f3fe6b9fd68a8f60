#include "service/sim/hall_array.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "firmware/wire/scaling.h"
#include "service/base/limits.h"

namespace omni::sim {
namespace {

constexpr double kPeriodSpread = 0.005;  // oscillators differ by up to +-0.5 %

}  // namespace

HallArray::HallArray(const base::DeviceGeometry& device, Random& random, std::int64_t start_ns)
    : noise_T_(device.sensor_noise_T),
      lsb_T_(device.sensor_lsb_T),
      full_scale_(wire::ToCounts<std::uint16_t>(
          std::min(device.sensor_range_T, device.sensor_lsb_T * std::numeric_limits<std::int16_t>::max()),
          device.sensor_lsb_T)) {
  for (Sensor& sensor : sensors_) {
    sensor.period_ns = std::llround(base::kTickPeriod_ns * (1 + random.Uniform(-kPeriodSpread, kPeriodSpread)));
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

void HallArray::Sample(std::size_t index, std::int64_t sample_ns, const Vec3& reading_T, Random& random) noexcept {
  Sensor& sensor = sensors_[index];
  const std::array<double, 3> reading{reading_T.x, reading_T.y, reading_T.z};
  const double full_scale_T = full_scale_ * lsb_T_;
  sensor.fresh = true;
  sensor.sampled_ns = sample_ns;
  sensor.saturated = 0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const double noisy_T = reading[axis] + noise_T_[axis] * random.Normal();
    if (!(std::abs(noisy_T) < full_scale_T)) sensor.saturated |= 1U << axis;
    sensor.counts[axis] = wire::ToCounts<std::int16_t>(std::clamp(noisy_T, -full_scale_T, full_scale_T), lsb_T_);
  }
}

std::int64_t HallArray::Report(wire::Telemetry& telemetry) noexcept {
  std::int64_t newest_ns = kNever_ns;
  for (const Sensor& sensor : sensors_) newest_ns = std::max(newest_ns, sensor.sampled_ns);
  if (newest_ns == kNever_ns) newest_ns = 0;
  telemetry.fresh_mask = 0;
  telemetry.saturated_mask = 0;
  for (std::size_t i = 0; i < sensors_.size(); ++i) {
    const Sensor& sensor = sensors_[i];
    std::copy(sensor.counts.begin(), sensor.counts.end(), telemetry.field[i]);
    telemetry.fresh_mask = static_cast<std::uint8_t>(telemetry.fresh_mask | (sensor.fresh ? 1U << i : 0U));
    telemetry.saturated_mask |= sensor.saturated << (3 * i);
    telemetry.age[i] = sensor.sampled_ns == kNever_ns
                           ? std::numeric_limits<std::uint8_t>::max()
                           : wire::ToCounts<std::uint8_t>(static_cast<double>(newest_ns - sensor.sampled_ns),
                                                          static_cast<double>(wire::kAgeUnit_ns));
  }
  return newest_ns;
}

}  // namespace omni::sim
