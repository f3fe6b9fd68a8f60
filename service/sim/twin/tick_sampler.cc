#include "service/sim/twin/tick_sampler.h"

#include <algorithm>

namespace omni::sim {
namespace {

const MagnetPose* PoseOf(const Snapshot& state) noexcept { return state.present ? &state.pose : nullptr; }

Environment MakeEnvironment(const base::TruthEffects& effects, std::uint64_t seed) noexcept {
  Random random(seed);
  return Environment(effects, random);
}

}  // namespace

TickSampler::TickSampler(const base::DeviceGeometry& device, const base::TruthEffects& effects,
                         const base::SensorParameters& sensor, TruthModel& truth, const Snapshot& first,
                         std::uint64_t environment_seed, std::int64_t start_ns, Random& random)
    : device_(device),
      effects_(effects),
      truth_(truth),
      environment_(MakeEnvironment(effects, environment_seed)),
      memory_(effects, device.core_radius_m),
      remembers_(effects.remanence_Am2 > 0 || effects.core_conductivity_S_m > 0),
      hall_(device, sensor, start_ns, random),
      now_ns_(start_ns) {
  held_.fill({first, {}});
  if (remembers_) memory_.Start(truth_.InducedMoment(PoseOf(first), first.current_A, environment_.At(0)));
}

void TickSampler::Begin() noexcept {
  held_.front() = held_[added_];
  added_ = 0;
}

void TickSampler::Add(const Snapshot& state, const Surroundings& background) noexcept {
  now_ns_ += kSubStep_ns;
  if (remembers_) memory_.Step(truth_.InducedMoment(PoseOf(state), state.current_A, background), kSubStep_s);
  held_[++added_] = {state, memory_.moment_Am2()};
}

Surroundings TickSampler::SurroundingsNow(double run_s) noexcept {
  run_s_ = run_s;
  Surroundings now = environment_.At(run_s);
  now.core_moment_Am2 = memory_.moment_Am2();
  return now;
}

TickSampler::Held TickSampler::Between(std::int64_t t_ns) const noexcept {
  const std::int64_t start_ns = now_ns_ - static_cast<std::int64_t>(added_) * kSubStep_ns;
  const std::int64_t since_start_ns = std::max<std::int64_t>(0, t_ns - start_ns);
  const std::size_t i = std::min(static_cast<std::size_t>(since_start_ns / kSubStep_ns), added_ - 1);
  const double s = static_cast<double>(since_start_ns - static_cast<std::int64_t>(i) * kSubStep_ns) /
                   static_cast<double>(kSubStep_ns);
  const Held& a = held_[i];
  const Held& b = held_[i + 1];
  Held between = b;
  const auto mix = [s](const Vec3& from, const Vec3& to) { return from + s * (to - from); };
  between.state.pose.centre_base_m = mix(a.state.pose.centre_base_m, b.state.pose.centre_base_m);
  between.state.pose.axis_base = Normalized(mix(a.state.pose.axis_base, b.state.pose.axis_base));
  between.core_moment_Am2 = mix(a.core_moment_Am2, b.core_moment_Am2);
  for (std::size_t k = 0; k < a.state.current_A.size(); ++k) {
    between.state.current_A[k] = a.state.current_A[k] + s * (b.state.current_A[k] - a.state.current_A[k]);
  }
  return between;
}

Snapshot TickSampler::StateAt(std::int64_t t_ns) const noexcept { return Between(t_ns).state; }

// A triangle seen at a random instant is evenly distributed over its height.
CoilArray TickSampler::WithRipple(CoilArray current_A, Random& random) const noexcept {
  if (!(effects_.pwm_frequency_Hz > 0)) return current_A;
  for (std::size_t k = 0; k < current_A.size(); ++k) {
    const base::CoilGeometry& coil = device_.coils[k];
    current_A[k] += effects_.pwm_residual * random.Uniform(-0.5, 0.5) *
                    RipplePeakToPeak(current_A[k], device_.supply_V, coil.resistance_20C_ohm, coil.inductance_H,
                                     effects_.pwm_frequency_Hz);
  }
  return current_A;
}

void TickSampler::TakeSamples(const Surroundings& background, Random& random) noexcept {
  for (std::size_t i = 0; i < base::kSensorCount; ++i) {
    std::int64_t sample_ns = 0;
    if (!hall_.NextSample(i, now_ns_, sample_ns)) continue;
    const Held held = Between(sample_ns);
    Surroundings then = background;
    then.core_moment_Am2 = held.core_moment_Am2;
    then.background_base_T += environment_.MainsField(1e-9 * static_cast<double>(sample_ns));
    const CoilArray current_A = WithRipple(held.state.current_A, random);
    const auto reading = [&](std::size_t sensor) {
      return truth_.SensorField(sensor, PoseOf(held.state), current_A, then);
    };
    const base::SensorFault* fault = environment_.FaultOf(i, run_s_);
    const auto is = [&](base::SensorFaultKind kind) { return fault != nullptr && fault->kind == kind; };
    if (is(base::SensorFaultKind::kStuck)) {
      hall_.RepeatSample(i, sample_ns);
    } else if (is(base::SensorFaultKind::kHuge)) {
      hall_.TakeSample(i, sample_ns, {fault->value, fault->value, fault->value}, random);
    } else if (is(base::SensorFaultKind::kSwapped)) {
      const int other = fault->sensor == static_cast<int>(i) ? fault->other : fault->sensor;
      hall_.TakeSample(i, sample_ns, reading(static_cast<std::size_t>(other)), random);
    } else if (!is(base::SensorFaultKind::kStopped)) {
      hall_.TakeSample(i, sample_ns, (is(base::SensorFaultKind::kGain) ? fault->value : 1) * reading(i), random);
    }
  }
}

}  // namespace omni::sim
