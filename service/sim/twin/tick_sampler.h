// One device tick seen by the sensors: the states at its sub-steps, the core's memory of them, and every sensor's
// sample at its own instant in between. Twin and traces share it.
#pragma once

#include <array>
#include <cstdint>

#include "service/sim/coils/effects.h"
#include "service/sim/coils/hall_array.h"
#include "service/sim/fields/truth_model.h"

namespace omni::sim {

struct Snapshot {
  MagnetPose pose;
  bool present = false;
  CoilArray current_A{};
};

class TickSampler {
 public:
  static constexpr int kSubSteps = 4;
  static constexpr std::int64_t kSubStep_ns = base::kTickPeriod_ns / kSubSteps;
  static constexpr double kSubStep_s = base::kTickPeriod_s / kSubSteps;

  // Time starts at `start_ns` with everything settled in `first`. `environment_seed`: of the drift's direction.
  TickSampler(const base::DeviceGeometry& device, const base::TruthEffects& effects,
              const base::SensorParameters& sensor, TruthModel& truth, const Snapshot& first,
              std::uint64_t environment_seed, std::int64_t start_ns, Random& random);

  // A tick: Begin, kSubSteps times Add, Sample. Fewer Adds make a shorter one.
  void Begin() noexcept;
  void Add(const Snapshot& state, const Surroundings& background) noexcept;
  void TakeSamples(const Surroundings& background, Random& random) noexcept;

  // Background and temperatures, with the core's memory as it is now. The run's time is kept for faults of sensors.
  Surroundings SurroundingsNow(double run_s) noexcept;

  // The state at an instant of the last tick, linear between sub-steps: at 2 m/s and 50 m/s^2 within a micrometre.
  Snapshot StateAt(std::int64_t t_ns) const noexcept;

  HallArray& hall() noexcept { return hall_; }
  const HallArray& hall() const noexcept { return hall_; }
  std::int64_t now_ns() const noexcept { return now_ns_; }

 private:
  struct Held {
    Snapshot state;
    Vec3 core_moment_Am2;
  };
  Held Between(std::int64_t t_ns) const noexcept;
  CoilArray WithRipple(CoilArray current_A, Random& random) const noexcept;

  base::DeviceGeometry device_;
  base::TruthEffects effects_;
  TruthModel& truth_;
  Environment environment_;
  CoreMemory memory_;
  bool remembers_;
  HallArray hall_;
  std::array<Held, kSubSteps + 1> held_;
  std::size_t added_ = 0;
  std::int64_t now_ns_;
  double run_s_ = 0;
};

}  // namespace omni::sim
