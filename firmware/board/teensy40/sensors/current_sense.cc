#include "firmware/board/teensy40/sensors/current_sense.h"

#include "firmware/board/teensy40/timebase.h"
#include "firmware/drivers/ina260_registers.h"

namespace omni::board {
namespace {

namespace ina260 = drivers::ina260;
using drivers::BusStatus;

// The alert changes sides only for a current that certainly has the other sign: 1 A.
constexpr std::int16_t kSideCounts = 800;
constexpr std::uint32_t kCheckSteps = 64;  // a chip every 16 ms
constexpr int kAlertWrites = 3;
constexpr std::uint8_t kSupplyMisses = 4;  // 1 ms: the capacitors keep the supply from changing faster

ina260::Mode ModeOf(int chip) noexcept {
  return chip == CurrentSense::kSupply ? ina260::Mode::kCurrentAndVoltage : ina260::Mode::kCurrentOnly;
}

I2cJob ReadOf(int chip, std::uint8_t number) noexcept {
  I2cJob job;
  job.address = CurrentSense::kAddress[chip];
  job.out[0] = number;
  job.out_size = 1;
  job.read = true;
  return job;
}

I2cJob WriteOf(int chip, std::uint8_t number, std::uint16_t value) noexcept {
  I2cJob job;
  job.address = CurrentSense::kAddress[chip];
  job.out[0] = number;
  job.out[1] = static_cast<std::uint8_t>(value >> 8);
  job.out[2] = static_cast<std::uint8_t>(value);
  job.out_size = 3;
  return job;
}

std::uint16_t Value(const I2cJob& job) noexcept { return static_cast<std::uint16_t>(job.in[0] << 8 | job.in[1]); }

}  // namespace

CurrentSense::CurrentSense(float alert_A) noexcept
    : chips_{Chip(bus_, kAddress[0]), Chip(bus_, kAddress[1]), Chip(bus_, kAddress[2]), Chip(bus_, kAddress[3])},
      limit_counts_(ina260::CurrentCounts(alert_A)) {}

void CurrentSense::Start() noexcept {
  bus_.Start();
  for (int chip = 0; chip < kChips; ++chip) chips_[chip].Start(ModeOf(chip), limit_counts_);
}

void CurrentSense::TakeCurrent(int coil) noexcept {
  const I2cJob& job = jobs_[coil];
  const auto bit = static_cast<std::uint8_t>(1U << coil);
  if (job.status != BusStatus::kOk || !running(coil)) {
    answers_ = static_cast<std::uint8_t>(answers_ & ~bit);
    return;
  }
  current_[coil] = static_cast<std::int16_t>(Value(job));
  answers_ = static_cast<std::uint8_t>(answers_ | bit);
}

void CurrentSense::CollectReadings(firmware::Inputs& inputs) noexcept {
  if (!paused_ && job_count_ != 0) {
    for (int coil = 0; coil < wire::kCoils; ++coil) TakeCurrent(coil);
    const I2cJob& supply = jobs_[kSupply];
    if (supply.status == BusStatus::kOk && running(kSupply)) {
      supply_ = Value(supply);
      supply_missed_ = 0;
    } else if (++supply_missed_ > kSupplyMisses) {
      supply_ = 0;  // an unmeasured supply counts as none
      supply_missed_ = kSupplyMisses;
    }
    if (checking_ >= 0) {
      const I2cJob& check = jobs_[job_count_ - 1];
      const auto wanted =
          static_cast<std::uint16_t>(ina260::kConfigFixed | static_cast<std::uint16_t>(ModeOf(checking_)));
      if (check.status == BusStatus::kOk && Value(check) != wanted) lost_[checking_] = true;
      checking_ = -1;
    }
  }
  for (int coil = 0; coil < wire::kCoils; ++coil) inputs.current[coil] = current_[coil];
  inputs.supply = supply_;
  inputs.current_answers = answers_;
}

bool CurrentSense::AlertJob(I2cJob& job) noexcept {
  for (int coil = 0; coil < wire::kCoils; ++coil) {
    Alert& alert = alerts_[coil];
    if (!running(coil)) continue;
    const std::int16_t current = current_[coil];
    if (alert.stage == 0 && (alert.negative ? current > kSideCounts : current < -kSideCounts)) {
      alert.negative = !alert.negative;
      alert.stage = kAlertWrites;
    }
    if (alert.stage == 0) continue;
    const std::uint16_t select = alert.negative ? ina260::kAlertUnderCurrent : ina260::kAlertOverCurrent;
    const int limit = alert.negative ? -limit_counts_ : limit_counts_;
    // Off while the limit changes sides; otherwise the old side would trigger at the new limit.
    switch (alert.stage--) {
      case 3:
        job = WriteOf(coil, ina260::kMaskEnable, ina260::kAlertLatch);
        break;
      case 2:
        job = WriteOf(coil, ina260::kAlertLimit, static_cast<std::uint16_t>(limit));
        break;
      default:
        job = WriteOf(coil, ina260::kMaskEnable, static_cast<std::uint16_t>(select | ina260::kAlertLatch));
    }
    return true;
  }
  return false;
}

bool CurrentSense::ReleaseJob(std::uint8_t lines_low, I2cJob& job) noexcept {
  const int coil = static_cast<int>(step_ % wire::kCoils);
  if ((lines_low >> coil & 1) == 0 || !running(coil)) return false;
  job = ReadOf(coil, ina260::kMaskEnable);
  return true;
}

bool CurrentSense::CheckJob(I2cJob& job) noexcept {
  if (step_ % kCheckSteps != 0) return false;
  checking_ = static_cast<int>(step_ / kCheckSteps % kChips);
  job = ReadOf(checking_, ina260::kConfig);
  return true;
}

void CurrentSense::RequestReadings(std::uint8_t lines_low, bool nothing_driven) noexcept {
  if (paused_) return;
  ++step_;
  job_count_ = 0;
  for (int coil = 0; coil < wire::kCoils; ++coil) jobs_[job_count_++] = ReadOf(coil, ina260::kCurrent);
  jobs_[job_count_++] = ReadOf(kSupply, ina260::kVoltage);
  I2cJob extra;
  if (AlertJob(extra) || (nothing_driven && ReleaseJob(lines_low, extra)) || CheckJob(extra))
    jobs_[job_count_++] = extra;
  bus_.Begin(jobs_, job_count_);
}

void CurrentSense::Maintain() noexcept {
  for (int i = 0; i < kChips; ++i) {
    const int chip = (next_start_ + i) % kChips;
    if (running(chip)) continue;
    next_start_ = (chip + 1) % kChips;
    paused_ = true;
    const std::uint32_t begin = Timebase::NowLow32_us();
    while (bus_.busy() && Timebase::NowLow32_us() - begin < CurrentBus::kPollBound_us) {
    }
    if (chips_[chip].Start(ModeOf(chip), limit_counts_) == drivers::ChipStatus::kOk) lost_[chip] = false;
    if (chip < wire::kCoils) alerts_[chip] = Alert();
    job_count_ = 0;
    checking_ = -1;
    paused_ = false;
    return;
  }
}

}  // namespace omni::board
