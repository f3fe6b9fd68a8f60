#include "firmware/board/teensy40/sensors/hall_array.h"

namespace omni::board {
namespace {
constexpr std::uint64_t kAgeMax_us = 65535;
}  // namespace

void HallArray::Start() noexcept {
  StartHallBus();
  for (Channel& channel : channels_) channel.chip.Start();
}

void HallArray::ReadOne(int index, std::uint64_t now_us, firmware::Inputs& inputs) noexcept {
  Channel& channel = channels_[index];
  const drivers::ChipStatus status = channel.chip.Read(channel.sample);
  const auto bit = static_cast<std::uint8_t>(1U << index);
  if (status == drivers::ChipStatus::kOk) {
    channel.sampled_us = now_us;
    inputs.field_fresh = static_cast<std::uint8_t>(inputs.field_fresh | bit);
  }
  if (status == drivers::ChipStatus::kOk || status == drivers::ChipStatus::kNoNewSample) {
    inputs.field_answers = static_cast<std::uint8_t>(inputs.field_answers | bit);
  }
  for (int axis = 0; axis < 3; ++axis) inputs.field[index][axis] = channel.sample.field[axis];
  const std::uint64_t age_us = now_us - channel.sampled_us;
  inputs.field_age_us[index] = static_cast<std::uint16_t>(age_us < kAgeMax_us ? age_us : kAgeMax_us);
}

void HallArray::Read(std::uint64_t now_us, firmware::Inputs& inputs) noexcept {
  inputs.field_fresh = inputs.field_answers = 0;
  for (int i = 0; i < wire::kSensors; ++i) ReadOne(i, now_us, inputs);
}

void HallArray::SelfTest(bool on) noexcept {
  channels_[next_test_].chip.SetSelfTest(on);
  next_test_ = (next_test_ + 1) % wire::kSensors;
}

void HallArray::Maintain() noexcept {
  drivers::Lis3mdl<HallBus>& chip = channels_[next_check_].chip;
  next_check_ = (next_check_ + 1) % wire::kSensors;
  if (chip.started()) {
    chip.Verify();
  } else {
    chip.Start();
  }
}

}  // namespace omni::board
