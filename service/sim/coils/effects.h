// What has a memory or a clock: the core's hysteresis and eddy currents, the background, the magnet's temperature.
// Sizes are those of base::TruthEffects; equations (6)-(11) of docs/theory/truth.md.
#pragma once

#include <array>
#include <cstdint>

#include "service/base/truth_parameters.h"
#include "service/sim/fields/random.h"
#include "service/sim/fields/vec3.h"

namespace omni::sim {

// All that a reading depends on besides pose and currents.
struct Surroundings {
  Vec3 core_moment_Am2;     // of the core beyond what tool, coils and background induce at once
  Vec3 background_base_T;   // uniform, as it would be without the core
  double magnet_scale = 1;  // of the tool's moment
  double sensor_warming_K = 0;
  std::uint32_t steel_mask = 0;  // pieces of steel that are there
  // Other magnets, as dipoles.
  struct Magnet {
    Vec3 position_base_m, moment_Am2;
  };
  std::array<Magnet, base::kOtherMagnetsMax> magnets;
  std::size_t magnet_count = 0;
};

// The core's moment lags behind what is induced at once (eddy currents) and keeps a part of it (hysteresis).
class CoreMemory {
 public:
  CoreMemory(const base::TruthEffects& effects, double core_radius_m) noexcept;

  // Settled, not magnetised.
  void Start(const Vec3& induced_Am2) noexcept;
  // `induced_Am2` has changed linearly over the last dt > 0.
  void Step(const Vec3& induced_Am2, double dt_s) noexcept;

  Vec3 moment_Am2() const noexcept;

 private:
  // Play operators [Bergqvist 1997]: friction of three sizes, whose mean is the greatest remanence.
  static constexpr std::array<double, 3> kPlay{0.5, 1.0, 1.5};
  struct Pole {
    double time_s = 0;
    double weight = 0;
    Vec3 lagged_Am2;
  };
  static constexpr std::size_t kPoles = 48;  // to far beyond what a sensor sees

  double remanence_Am2_;
  bool eddies_;
  Vec3 induced_Am2_;
  std::array<Vec3, kPlay.size()> played_Am2_;
  std::array<Pole, kPoles> poles_;
};

// Background and the magnet's temperature as functions of time.
class Environment {
 public:
  // Draws the directions of drift and mains, and the phases of the mains.
  Environment(const base::TruthEffects& effects, Random& random);

  // Without the core's memory and the mains. `t_s` since the start of the run.
  Surroundings At(double t_s) const noexcept;
  // Too fast for a tick: evaluate it at each sample's own instant.
  Vec3 MainsField(double t_s) const noexcept;
  // What is wrong with a sensor; null: nothing. The first fault that names it counts.
  const base::SensorFault* FaultOf(std::size_t sensor, double t_s) const noexcept;

 private:
  base::TruthEffects effects_;
  Vec3 drift_base_T_;
  Vec3 mains_base_;  // unit
  std::array<double, 3> mains_phase_rad_{};
};

// Ripple of a driver that switches `supply_V` at `frequency_Hz` onto a coil so that `current_A` flows, peak to peak.
double RipplePeakToPeak(double current_A, double supply_V, double resistance_ohm, double inductance_H,
                        double frequency_Hz) noexcept;

}  // namespace omni::sim
