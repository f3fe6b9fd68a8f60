#include "firmware/core/safety/self_test.h"

#include "firmware/core/safety/fault_rules.h"

namespace omni::firmware {
namespace {

constexpr int kSamples = 16;                             // of every sensor, before and in the test field
constexpr int kSamplesTimeout_steps = 50 * kStepsPerMs;  // 16 samples at 1 kHz take 16 ms
constexpr int kSettle_steps = 60 * kStepsPerMs;          // as in ST's procedure for its sensors
constexpr int kAttempts = 4;                             // a pen moving near the base disturbs one

// LIS3MDL data sheet, sensor characteristics, self-test: +1 to +3 G on x and y, +0.1 to +1 G on z.
struct Range_T {
  float low_T, high_T;
};
constexpr Range_T kTestField[3] = {{1e-4F, 3e-4F}, {1e-4F, 3e-4F}, {1e-5F, 1e-4F}};

constexpr float kCoil_A = 1;
constexpr int kDrive_steps = 30 * kStepsPerMs;    // 20 time constants
constexpr int kMeasure_steps = 10 * kStepsPerMs;  // the last of them
constexpr int kRest_steps = 10 * kStepsPerMs;
constexpr float kMeasuredTolerance = 0.2F;

}  // namespace

void SelfTest::Start(std::uint8_t parts) noexcept {
  parts_ = parts;
  attempt_ = 0;
  coil_ = 0;
  Enter((parts & kRetestHall) != 0 ? Phase::kHallRest : Phase::kCoilWake);
  if (parts == 0) Enter(Phase::kDone);
}

void SelfTest::Enter(Phase phase) noexcept {
  phase_ = phase;
  in_phase_ = 0;
  if (phase == Phase::kHallRest) rest_ = Sums{};
  if (phase == Phase::kHallField) field_ = Sums{};
  if (phase == Phase::kHallAgain) again_ = Sums{};
  if (phase == Phase::kCoilDrive) current_sum_A_ = voltage_sum_V_ = 0;
}

SelfTest::Step SelfTest::Advance(const Settings& settings, const HallWatch& hall, const HallVerdict& verdict,
                                 const CoilSample (&coils)[wire::kCoils]) noexcept {
  Step step;
  if (phase_ == Phase::kDone) {
    step.result = Result::kPassed;
    return step;
  }
  ++in_phase_;
  if (drives_coils()) {
    CoilPhases(settings, coils, step);
  } else {
    HallPhases(settings, hall, verdict, step);
  }
  step.test_field = phase_ == Phase::kHallSettle || phase_ == Phase::kHallField;
  if (step.result == Result::kRefused) Enter(Phase::kDone);
  return step;
}

void SelfTest::HallPhases(const Settings& settings, const HallWatch& hall, const HallVerdict& verdict,
                          Step& step) noexcept {
  switch (phase_) {
    case Phase::kHallRest:
      if (Collect(settings, hall, verdict, rest_)) Enter(Phase::kHallSettle);
      break;
    case Phase::kHallSettle:
      if (in_phase_ >= kSettle_steps) Enter(Phase::kHallField);
      break;
    case Phase::kHallField:
      if (Collect(settings, hall, verdict, field_)) Enter(Phase::kHallRelease);
      break;
    case Phase::kHallRelease:
      if (in_phase_ >= kSettle_steps) Enter(Phase::kHallAgain);
      break;
    default:
      if (Collect(settings, hall, verdict, again_)) JudgeHall(settings, step);
      break;
  }
}

// True once all sensors have delivered enough samples, or have had the time to.
bool SelfTest::Collect(const Settings& settings, const HallWatch& hall, const HallVerdict& verdict,
                       Sums& sums) noexcept {
  bool is_complete = true;
  for (int i = 0; i < wire::kSensors; ++i) {
    if (((verdict.fresh >> i) & 1U) != 0 && sums.count[i] < kSamples) {
      for (int axis = 0; axis < 3; ++axis) sums.sum[i][axis] += hall.field(i)[axis];
      ++sums.count[i];
    }
    is_complete = is_complete && sums.count[i] == kSamples;
  }
  sums.saturated_mask |= hall.saturated_mask(settings);
  return is_complete || in_phase_ >= kSamplesTimeout_steps;
}

// (5.1): before and after, so that a steady drift cancels. An axis that the pen saturates is not checked.
void SelfTest::JudgeHall(const Settings& settings, Step& step) noexcept {
  const std::uint32_t saturated_mask = rest_.saturated_mask | field_.saturated_mask | again_.saturated_mask;
  for (int i = 0; i < wire::kSensors; ++i) {
    const bool is_complete = rest_.count[i] == kSamples && field_.count[i] == kSamples && again_.count[i] == kSamples;
    for (int axis = 0; axis < 3; ++axis) {
      if (((saturated_mask >> (3 * i + axis)) & 1U) != 0) continue;
      const std::int32_t twice = 2 * field_.sum[i][axis] - rest_.sum[i][axis] - again_.sum[i][axis];
      const float shown_T = static_cast<float>(twice) / (2 * kSamples) * settings.field_lsb_T;
      if (is_complete && shown_T >= kTestField[axis].low_T && shown_T <= kTestField[axis].high_T) continue;
      if (++attempt_ < kAttempts) return Enter(Phase::kHallRest);
      step.result = Result::kRefused;
      step.fault = wire::kFaultHallSensor;
      step.part = static_cast<std::uint8_t>(i);
      step.value = is_complete ? shown_T : 0;
      return;
    }
  }
  AfterHall();
}

void SelfTest::AfterHall() noexcept { Enter((parts_ & kRetestCoils) != 0 ? Phase::kCoilWake : Phase::kDone); }

void SelfTest::CoilPhases(const Settings& settings, const CoilSample (&coils)[wire::kCoils], Step& step) noexcept {
  step.awake = true;
  if (phase_ == Phase::kCoilWake) {
    if (in_phase_ >= kWake_steps) Enter(Phase::kCoilDrive);
    return;
  }
  if (phase_ == Phase::kCoilRest) {
    if (in_phase_ < kRest_steps) return;
    Enter(++coil_ < wire::kCoils ? Phase::kCoilDrive : Phase::kDone);
    if (phase_ == Phase::kDone) step.awake = false;
    return;
  }
  step.voltage_V[coil_] = kCoil_A * ResistanceAt(settings, coil_, settings.air_C);
  if (in_phase_ > kDrive_steps - kMeasure_steps) {
    current_sum_A_ += coils[coil_].current_A;
    voltage_sum_V_ += coils[coil_].voltage_V;
  }
  if (in_phase_ >= kDrive_steps) JudgeCoil(settings, step);
}

// (5.2)
void SelfTest::JudgeCoil(const Settings& settings, Step& step) noexcept {
  const float expected_ohm = ResistanceAt(settings, coil_, settings.air_C);
  const float mean_A = current_sum_A_ / kMeasure_steps;
  const float mean_V = voltage_sum_V_ / kMeasure_steps;
  const bool flows = mean_A > kOpenShare * kCoil_A;
  const float resistance_ohm = flows ? mean_V / mean_A : 0;
  if (flows && Abs(resistance_ohm - expected_ohm) <= kMeasuredTolerance * expected_ohm) {
    resistance_ohm_[coil_] = resistance_ohm;
    return Enter(Phase::kCoilRest);
  }
  step.result = Result::kRefused;
  if (mean_A < -kOpenShare * kCoil_A) {
    step.fault = wire::kFaultModel;  // the sign is wrong
  } else if (!flows) {
    step.fault = wire::kFaultCoilOpen;
  }
  step.part = static_cast<std::uint8_t>(coil_);
  step.value = resistance_ohm;
}

}  // namespace omni::firmware
