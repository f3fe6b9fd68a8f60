#include "tests/support/drill.h"

#include <cstring>

#include "firmware/core/core.h"
#include "firmware/wire/frame.h"

namespace omni::firmware {
namespace {

constexpr int kCalm_steps = 2000;  // between two events, long enough to arm again
constexpr int kEvent_steps = 160;  // 40 ms
constexpr int kEventKinds = 10;
constexpr int kAskAgain_steps = 200;

class Random {
 public:
  std::uint32_t Next() noexcept {  // Numerical Recipes, "quick and dirty"; the upper bits are the good ones
    state_ = state_ * 1664525U + 1013904223U;
    return state_ >> 8;
  }
  std::int32_t IsWithin(std::int32_t size) noexcept {  // -size ... size
    return static_cast<std::int32_t>(Next() % static_cast<std::uint32_t>(2 * size + 1)) - size;
  }

 private:
  std::uint32_t state_ = 20'201'021;
};

enum class Event : std::uint8_t {
  kNone,
  kHostSilent,
  kEstop,
  kSupplyLow,
  kHallStuck,
  kHallDead,
  kOverCurrent,
  kDriver,
  kBadFrames,
  kSwitch
};
static_assert(static_cast<int>(Event::kSwitch) + 1 == kEventKinds, "all kinds");

// Coils in microamperes: L di/dt = U - R i in steps of 50 us.
class IntegerPlant {
 public:
  void Step(const Outputs& outputs, Event event, Random& random, Inputs& inputs) noexcept {
    inputs.now_us += kStepPeriod_us;
    ++step_;
    inputs.supply = event == Event::kSupplyLow ? 6400 : 14400;
    inputs.board_temperature = 3000;
    inputs.fan_rpm = outputs.fan > 0 ? 2500 : 0;
    inputs.emergency_stop = event == Event::kSwitch ? 1 : 0;
    inputs.driver_fault = event == Event::kDriver ? 2 : 0;
    inputs.current_answers = 7;
    inputs.field_answers = event == Event::kHallDead ? 0xEF : 0xFF;
    for (int k = 0; k < wire::kCoils; ++k) Coil(k, outputs, event, inputs);
    inputs.field_fresh = 0;
    for (int i = 0; i < wire::kSensors; ++i) Hall(i, outputs, event, random, inputs);
  }

 private:
  void Coil(int k, const Outputs& outputs, Event event, Inputs& inputs) noexcept {
    constexpr std::int64_t kResistance_mohm[] = {645, 679, 710};
    constexpr std::int64_t kInductance_uH[] = {1080, 1110, 1130};
    const std::int64_t supply_uV = std::int64_t{inputs.supply} * 1250;
    const bool is_awake = ((outputs.awake >> k) & 1U) != 0;
    const std::int64_t voltage_uV = is_awake ? supply_uV * outputs.duty[k] / wire::kDutyFull : 0;
    std::int64_t sum_uA = 0;
    for (int sub = 0; sub < 5; ++sub) {
      const std::int64_t before_uA = current_uA_[k];
      current_uA_[k] += (voltage_uV - before_uA * kResistance_mohm[k] / 1000) * 50 / kInductance_uH[k];
      sum_uA += (before_uA + current_uA_[k]) / 2;
    }
    if (!is_awake) current_uA_[k] = current_uA_[k] / 2;
    const std::int64_t mean_uA = event == Event::kOverCurrent && k == 1 ? 16'000'000 : sum_uA / 5;
    inputs.current[k] = static_cast<std::int16_t>(mean_uA / 1250);
    inputs.voltage[k] = static_cast<std::uint16_t>((voltage_uV < 0 ? -voltage_uV : voltage_uV) / 1250);
  }

  void Hall(int i, const Outputs& outputs, Event event, Random& random, Inputs& inputs) noexcept {
    if ((step_ + static_cast<std::uint32_t>(i)) % kStepsPerTick != 0) {
      inputs.field_age_us[i] = static_cast<std::uint16_t>(inputs.field_age_us[i] + kStepPeriod_us);
      return;
    }
    inputs.field_age_us[i] = static_cast<std::uint16_t>(30 * i);
    inputs.field_fresh = static_cast<std::uint8_t>(inputs.field_fresh | (1U << i));
    if (event == Event::kHallStuck && i == 5) return;
    constexpr std::int32_t kTestField[] = {3422, 3422, 855};  // 2, 2 and 0.5 G
    for (int axis = 0; axis < 3; ++axis) {
      const std::int32_t phase = static_cast<std::int32_t>(step_ / 4 % 2000);
      const std::int32_t slow = 3 * (phase < 1000 ? phase : 2000 - phase);
      const std::int32_t test = outputs.hall_self_test != 0 ? kTestField[axis] : 0;
      inputs.field[i][axis] = static_cast<std::int16_t>(slow - 1500 + 300 * i + test + random.IsWithin(14));
    }
  }

  std::int64_t current_uA_[wire::kCoils] = {};
  std::uint32_t step_ = 0;
};

class Host {
 public:
  explicit Host(Core& core) noexcept : core_(core) {}

  void Step(std::uint32_t step, Event event, Random& random) noexcept {
    if (event == Event::kHostSilent) return;
    if (event == Event::kEstop) Send(wire::Estop{});
    if (event == Event::kBadFrames) SendNoise(random);
    if (step % kStepsPerTick == 0) SendCommand(step, random);
    if (core_.state() == wire::State::kArmed || step % kAskAgain_steps != 0) return;
    Send(wire::Arm{});
    wire::Config config;
    config.id = static_cast<std::uint16_t>(wire::ConfigId::kPowerMax_W);
    Send(config);
  }

  void Hear(const std::uint8_t* frame, std::size_t size) noexcept {
    wire::FrameView view;
    wire::Arm arm;
    if (wire::OpenFrame(frame, size, view) != wire::Status::kOk) return;
    if (wire::Decode(view, arm) != wire::Status::kOk || arm.step != wire::ArmStep::kChallenge) return;
    arm.step = wire::ArmStep::kConfirm;
    Send(arm);
  }

 private:
  template <class Message>
  void Send(const Message& message) noexcept {
    std::uint8_t frame[wire::kFrameSizeMax];
    const wire::Encoded encoded = wire::Encode(message, ++seq_, 0, frame, sizeof frame);
    core_.Receive(frame, encoded.size);
  }

  void SendCommand(std::uint32_t step, Random& random) noexcept {
    wire::Command command;
    command.mode = wire::Mode::kCurrent;
    command.host_us = std::uint64_t{step} * kStepPeriod_us;
    if (step % 400 == 0) {
      for (float& set_point_A : set_point_A_) set_point_A = static_cast<float>(random.IsWithin(1400)) / 100.0F;
    }
    for (int k = 0; k < wire::kCoils; ++k) command.set_point_A[k] = set_point_A_[k];
    Send(command);
  }

  void SendNoise(Random& random) noexcept {
    std::uint8_t frame[wire::kFrameSizeMax];
    wire::Command command;
    const wire::Encoded encoded = wire::Encode(command, ++seq_, 0, frame, sizeof frame);
    frame[random.Next() % encoded.size] ^= static_cast<std::uint8_t>(1U << (random.Next() % 8));
    core_.Receive(frame, encoded.size);
    core_.Receive(frame, random.Next() % encoded.size);
  }

  Core& core_;
  std::uint16_t seq_ = 0;
  float set_point_A_[wire::kCoils] = {};
};

std::uint32_t Chain(std::uint32_t crc, const std::uint8_t* data, std::size_t size) noexcept {
  std::uint8_t link[wire::kFrameSizeMax + 4];
  std::memcpy(link, &crc, 4);
  std::memcpy(link + 4, data, size);
  return wire::Crc32c(link, size + 4);
}

}  // namespace

DrillTally DrillWithTally(std::uint32_t steps) noexcept {
  DrillTally tally;
  FaultRecord record;
  Core core(Settings{}, ResetCause::kPower, 1, record);
  Random random;
  IntegerPlant plant;
  Host host(core);
  Inputs inputs;
  Outputs outputs;
  for (std::uint32_t step = 0; step < steps; ++step) {
    const std::uint32_t round = step / kCalm_steps;
    const bool has_event = step % kCalm_steps >= kCalm_steps - kEvent_steps;
    const Event event = has_event ? static_cast<Event>(round % kEventKinds) : Event::kNone;
    plant.Step(outputs, event, random, inputs);
    core.Step(inputs, outputs);
    std::uint8_t bytes[sizeof outputs];
    std::memcpy(bytes, &outputs, sizeof outputs);
    tally.crc = Chain(tally.crc, bytes, sizeof bytes);
    std::uint8_t frame[wire::kFrameSizeMax];
    for (std::size_t size = core.NextFrame(frame, sizeof frame); size > 0; size = core.NextFrame(frame, sizeof frame)) {
      tally.crc = Chain(tally.crc, frame, size);
      ++tally.frames;
      host.Hear(frame, size);
    }
    host.Step(step, event, random);
    tally.faults_seen |= core.faults();
    if (core.state() == wire::State::kArmed) ++tally.armed_steps;
  }
  return tally;
}

std::uint32_t DrillChecksum(std::uint32_t steps) noexcept { return DrillWithTally(steps).crc; }

}  // namespace omni::firmware
