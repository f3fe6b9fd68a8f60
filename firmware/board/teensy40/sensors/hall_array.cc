#include "firmware/board/teensy40/sensors/hall_array.h"

namespace omni::board {
namespace {

constexpr std::uint64_t kAgeMax_us = 65535;
constexpr int kLooks = wire::kSensors / 2;  // in a step
constexpr int kReads = 2;
constexpr std::uint64_t kLookPeriod_us = 2 * firmware::kStepPeriod_us;
constexpr std::uint16_t kFrozenSteps = 400;  // without a new sample: reset

}  // namespace

void HallArray::Start() noexcept {
  StartHallBus();
  for (Channel& channel : channels_) channel.chip.Start();
}

void HallArray::Look(std::uint64_t now_us) noexcept {
  static_assert(kFrozenSteps % kSilentSteps == 0, "they are counted together");
  const int first = second_half_ ? kLooks : 0;
  second_half_ = !second_half_;
  for (int i = first; i < first + kLooks; ++i) {
    Channel& channel = channels_[i];
    const bool silent = channel.quiet_steps % kSilentSteps >= kSilentSteps - 2;
    if (channel.waits || (!channel.answers && !silent)) continue;  // an undriven line would look new every time
    channel.waits = channel.chip.CheckForSample() == drivers::ChipStatus::kOk || silent;
    channel.seen_us = now_us;
  }
}

// Whether it has a new sample.
bool HallArray::ReadOne(int index) noexcept {
  Channel& channel = channels_[index];
  channel.waits = false;
  const drivers::ChipStatus status = channel.chip.Read(channel.sample);
  const bool fresh = status == drivers::ChipStatus::kOk;
  channel.answers = fresh || status == drivers::ChipStatus::kNoNewSample;
  if (!fresh) return false;
  channel.sampled_us = channel.seen_us - kLookPeriod_us / 2;
  channel.quiet_steps = 0;
  channel.reset = false;
  return true;
}

void HallArray::ReadWaiting(int reads, firmware::Inputs& inputs) noexcept {
  for (int i = 0; i < wire::kSensors && reads > 0; ++i) {
    const int index = next_read_;
    if (channels_[index].waits) {
      --reads;
      if (ReadOne(index)) inputs.field_fresh = static_cast<std::uint8_t>(inputs.field_fresh | 1U << index);
    }
    next_read_ = (next_read_ + 1) % wire::kSensors;
  }
}

void HallArray::Read(std::uint64_t now_us, firmware::Inputs& inputs) noexcept {
  Look(now_us);
  inputs.field_fresh = inputs.field_answers = 0;
  ReadWaiting(kReads, inputs);
  for (int i = 0; i < wire::kSensors; ++i) {
    Channel& channel = channels_[i];
    const int quiet = channel.quiet_steps + 1;
    channel.quiet_steps = static_cast<std::uint16_t>(quiet < kFrozenSteps + kSilentSteps ? quiet : kFrozenSteps);
    if (channel.answers) inputs.field_answers = static_cast<std::uint8_t>(inputs.field_answers | 1U << i);
    for (int axis = 0; axis < 3; ++axis) inputs.field[i][axis] = channel.sample.field[axis];
    const std::uint64_t age_us = now_us - channel.sampled_us;
    inputs.field_age_us[i] = static_cast<std::uint16_t>(age_us < kAgeMax_us ? age_us : kAgeMax_us);
  }
}

void HallArray::SelfTest(bool on) noexcept {
  channels_[next_test_].chip.SetSelfTest(on);
  next_test_ = (next_test_ + 1) % wire::kSensors;
}

void HallArray::Maintain() noexcept {
  Channel& channel = channels_[next_check_];
  next_check_ = (next_check_ + 1) % wire::kSensors;
  const bool frozen = channel.quiet_steps >= kFrozenSteps && !channel.reset;
  if (channel.chip.started() && !frozen) {
    channel.chip.Verify();
    return;
  }
  channel.reset = channel.reset || frozen;
  channel.chip.Start();
}

}  // namespace omni::board
