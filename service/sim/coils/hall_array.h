// Eight Hall sensors, each on its own oscillator: sample instants, noise, quantisation, saturation.
#pragma once

#include <array>
#include <cstdint>
#include <limits>

#include "service/base/device_geometry.h"
#include "service/base/truth_parameters.h"
#include "service/sim/fields/random.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {

class HallArray {
 public:
  static constexpr std::int64_t kNever_ns = std::numeric_limits<std::int64_t>::min();

  // No sample is earlier than `start_ns`.
  HallArray(const base::DeviceGeometry& device, const base::SensorParameters& sensor_parameters, std::int64_t start_ns,
            Random& random);

  // The instant of sensor `index`'s newest sample at or before `t_ns`; false: none since the last call.
  bool NextSample(std::size_t index, std::int64_t t_ns, std::int64_t& sample_ns) noexcept;

  // Takes that sample of the noise-free reading.
  void TakeSample(std::size_t index, std::int64_t sample_ns, const Vec3& reading_T, Random& random) noexcept;
  // Repeats the sample before, marked as new.
  void RepeatSample(std::size_t index, std::int64_t sample_ns) noexcept;

  // What the chip's output registers hold, and when they were written.
  struct Registers {
    std::array<std::int16_t, 3> counts{};
    std::int64_t sampled_ns = kNever_ns;
    bool fresh = false;  // written by the last step
  };
  Registers Read(std::size_t index) const noexcept {
    const Sensor& sensor = sensors_[index];
    return {sensor.counts, sensor.sampled_ns, sensor.fresh};
  }

 private:
  static constexpr std::array<double, 5> kFlickerTimes_s{0.01, 0.1, 1, 10, 100};
  struct Sensor {
    std::int64_t period_ns = 0;
    std::int64_t next_ns = 0;
    std::int64_t sampled_ns = kNever_ns;
    bool fresh = false;
    std::array<std::int16_t, 3> counts{};
    std::array<std::array<double, kFlickerTimes_s.size()>, 3> flicker_T{};  // per axis
  };
  double Flicker_T(Sensor& sensor, std::size_t axis, Random& random) const noexcept;

  std::array<Sensor, base::kSensorCount> sensors_;
  std::array<double, 3> noise_T_;
  std::array<double, kFlickerTimes_s.size()> flicker_keep_{}, flicker_new_T_{};  // of each process, in one sample
  double lsb_T_;
  std::uint16_t full_scale_;
};

}  // namespace omni::sim
