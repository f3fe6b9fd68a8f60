// The shake of a hand: three waves per direction, 8 to 12 Hz unless stated [Elble, Koller 1990: physiological tremor;
// pathological tremors begin at 4 Hz].
#pragma once

#include <array>
#include <cmath>
#include <numbers>

#include "service/sim/fields/random.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {

struct TremorBand {
  double from_Hz = 8, to_Hz = 12;
};

class Tremor {
 public:
  // rms of the whole displacement.
  Tremor(double rms_m, Random& random, const TremorBand& band = {}) noexcept {
    const double amplitude_m = rms_m * std::sqrt(2.0 / kWaves);
    const std::array<Vec3, 3> directions{Vec3{amplitude_m, 0, 0}, Vec3{0, amplitude_m, 0}, Vec3{0, 0, amplitude_m}};
    for (std::size_t i = 0; i < waves_.size(); ++i) {
      waves_[i].rate_rad_s = 2 * std::numbers::pi * random.Uniform(band.from_Hz, band.to_Hz);
      waves_[i].phase_rad = 2 * std::numbers::pi * random.Uniform();
      waves_[i].amplitude_m = directions[i % 3];
    }
  }

  void AddTo(double t_s, Vec3& position_m, Vec3& velocity_m_s) const noexcept {
    for (const Wave& wave : waves_) {
      const double phase = wave.rate_rad_s * t_s + wave.phase_rad;
      position_m += std::sin(phase) * wave.amplitude_m;
      velocity_m_s += (wave.rate_rad_s * std::cos(phase)) * wave.amplitude_m;
    }
  }

  // No displacement is longer than this many rms: all waves of all directions at their crests.
  static constexpr double kReach_rms = 2.45;

 private:
  struct Wave {
    double rate_rad_s = 0;
    double phase_rad = 0;
    Vec3 amplitude_m;
  };
  static constexpr int kWaves = 9;
  std::array<Wave, kWaves> waves_{};
};

}  // namespace omni::sim
