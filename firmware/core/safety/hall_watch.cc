#include "firmware/core/safety/hall_watch.h"

#include "firmware/core/numbers.h"
#include "firmware/core/safety/fault_rules.h"
#include "firmware/wire/messages.h"

namespace omni::firmware {
namespace {

constexpr std::uint8_t BitOf(int i) noexcept { return static_cast<std::uint8_t>(1U << i); }

bool IsSaturated(std::int16_t counts, std::uint16_t full_scale) noexcept {
  return counts >= static_cast<std::int32_t>(full_scale) || counts <= -static_cast<std::int32_t>(full_scale);
}

bool AreEqual(const std::int16_t (&a)[3], const std::int16_t (&b)[3]) noexcept {
  return a[0] == b[0] && a[1] == b[1] && a[2] == b[2];
}

}  // namespace

HallVerdict HallWatch::Step(const Settings& settings, const Inputs& inputs) noexcept {
  HallVerdict verdict;
  WatchCurrents(inputs);
  for (int i = 0; i < wire::kSensors; ++i) {
    const bool answers = TestBit(inputs.field_answers, i);
    if (answers && TestBit(inputs.field_fresh, i)) Handle(settings, inputs, i, verdict);
    const bool is_stale = !has_sample_[i] || inputs.now_us - sample_us_[i] > kHallStale_us;
    if (!answers || is_stale) verdict.silent |= BitOf(i);
    if (equal_[i] >= RuleOf(wire::kFaultHallStuck).hold) verdict.stuck |= BitOf(i);
    if (jumped_[i] >= RuleOf(wire::kFaultHallJump).hold) verdict.jumps |= BitOf(i);
  }
  return verdict;
}

// A sensor whose word is clipped in all axes shows no noise, so equal samples prove nothing.
void HallWatch::Handle(const Settings& settings, const Inputs& inputs, int sensor, HallVerdict& verdict) noexcept {
  const auto& sample = inputs.field[sensor];
  const std::uint16_t full_scale = settings.field_full_scale;
  const bool is_clipped =
      IsSaturated(sample[0], full_scale) && IsSaturated(sample[1], full_scale) && IsSaturated(sample[2], full_scale);
  const bool repeats = has_sample_[sensor] && AreEqual(sample, field_[sensor]) && !is_clipped;
  equal_[sensor] = repeats ? static_cast<std::uint16_t>(equal_[sensor] + (equal_[sensor] < 0xFFFF ? 1 : 0)) : 0;

  const bool is_known = has_sample_[sensor] && inputs.now_us - sample_us_[sensor] <= kHallStale_us;
  if (is_known && jumped_[sensor] < RuleOf(wire::kFaultHallJump).hold && Jumps(settings, sensor, sample)) {
    ++jumped_[sensor];
    return;
  }
  jumped_[sensor] = 0;
  const std::uint64_t age_us = inputs.field_age_us[sensor];
  for (int axis = 0; axis < 3; ++axis) field_[sensor][axis] = sample[axis];
  sample_us_[sensor] = inputs.now_us > age_us ? inputs.now_us - age_us : 0;
  has_sample_[sensor] = true;
  verdict.fresh |= BitOf(sensor);
}

// (4.2): more than a magnet can cause within a sample, and more than the coils' own change explains.
bool HallWatch::Jumps(const Settings& settings, int sensor, const std::int16_t (&sample)[3]) const noexcept {
  const float full_scale = static_cast<float>(settings.field_full_scale);
  const float by_coils = kHallCoilDoubt * full_scale / settings.current_max_A * swing_A_;
  const float allowed = kHallJump_T / settings.field_lsb_T + by_coils;
  for (int axis = 0; axis < 3; ++axis) {
    const std::int32_t change = static_cast<std::int32_t>(sample[axis]) - field_[sensor][axis];
    if (!(Abs(static_cast<float>(change)) <= allowed)) return true;
  }
  return false;
}

void HallWatch::WatchCurrents(const Inputs& inputs) noexcept {
  at_ = (at_ + 1) % kCurrentMemory;
  std::int32_t swing = 0;
  for (int k = 0; k < wire::kCoils; ++k) {
    currents_[k][at_] = inputs.current[k];
    std::int32_t low = inputs.current[k], high = low;
    for (const std::int16_t current : currents_[k]) {
      low = current < low ? current : low;
      high = current > high ? current : high;
    }
    swing += high - low;
  }
  swing_A_ = static_cast<float>(swing) * static_cast<float>(wire::kCurrentUnit_A);
}

std::uint32_t HallWatch::saturated_mask(const Settings& settings) const noexcept {
  std::uint32_t mask = 0;
  for (int i = 0; i < wire::kSensors; ++i) {
    for (int axis = 0; axis < 3; ++axis) {
      if (IsSaturated(field_[i][axis], settings.field_full_scale)) mask |= 1U << (3 * i + axis);
    }
  }
  return mask;
}

}  // namespace omni::firmware
