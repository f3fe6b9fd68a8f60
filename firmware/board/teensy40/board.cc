#include "firmware/board/teensy40/board.h"

#include "firmware/board/teensy40/chip/chip.h"

namespace omni::board {
namespace {

constexpr std::uint32_t kSlowSteps = 400;     // thermometer: 100 ms
constexpr std::uint32_t kMaintainSteps = 64;  // a magnetometer is checked every 16 ms, each one every 128 ms
constexpr std::uint32_t kBlinkSteps = 2000;   // the lamp: half a second on, half a second off; lit continuously: armed

}  // namespace

Board::Board(const firmware::Settings& settings) noexcept : currents_(settings.current_trip_A), usb_(settings) {}

void Board::Start() noexcept {
  time_.Start(firmware::kStepPeriod_us);
  bridges_.Start();
  for (Bridge& driver : drivers_) driver.Start();
  fan_.Start();
  fan_.Set(255);  // until the core commands another speed
  thermometer_.Start();
  halls_.Start();
  currents_.Start();
  usb_.Start();
  nvic::Enable(Irq::kPit, Priority::kControl);
}

bool Board::AllAsleep() const noexcept {
  for (const Bridge& driver : drivers_) {
    if (driver.awake()) return false;
  }
  return true;
}

void Board::ReadFaults(firmware::Inputs& inputs) noexcept {
  inputs.driver_fault = 0;
  for (int i = 0; i < kBridges; ++i) {
    if (drivers_[i].fault()) inputs.driver_fault = static_cast<std::uint8_t>(inputs.driver_fault | 1U << i);
  }
  inputs.emergency_stop = bridges_.EmergencyStop() || usb_.EmergencyStop() ? 1 : 0;
  // Only after they have been reported, so that no short one is lost.
  if (bridges_.nothing_driven()) bridges_.ClearFaults();
}

// |duty| * supply: see current_sense.h.
void Board::ReadVoltages(firmware::Inputs& inputs) noexcept {
  for (int i = 0; i < kBridges; ++i) {
    const std::uint32_t magnitude = static_cast<std::uint32_t>(duty_[i] < 0 ? -duty_[i] : duty_[i]);
    inputs.voltage[i] = static_cast<std::uint16_t>(magnitude * inputs.supply / kDutyFull);
  }
}

void Board::Read(firmware::Inputs& inputs) noexcept {
  const std::uint64_t now_us = time_.Now();
  inputs.now_us = now_us;
  bridges_.SetTime(now_us);
  currents_.CollectReadings(inputs);
  ReadVoltages(inputs);
  halls_.Read(now_us, inputs);
  ReadFaults(inputs);
  tach_.Update();
  if (steps_ % kSlowSteps == 0) temperature_ = thermometer_.Read();
  inputs.board_temperature = temperature_;
  inputs.fan_rpm = static_cast<std::uint16_t>(tach_.rpm());
  steps_ = steps_ + 1;
}

void Board::Write(const firmware::Outputs& outputs) noexcept {
  for (int i = 0; i < kBridges; ++i) {
    const bool awake = (outputs.awake >> i & 1) != 0;
    drivers_[i].Apply(outputs.duty[i], awake);
    duty_[i] = drivers_[i].driving() ? outputs.duty[i] : std::int16_t{0};
  }
  all_asleep_ = AllAsleep();
  halls_.SelfTest(outputs.hall_self_test != 0);
  fan_.Set(outputs.fan);
  currents_.RequestReadings(bridges_.CoilFaultLines(), bridges_.nothing_driven());
  SetPin(Signal::kLed, !all_asleep_ || steps_ / kBlinkSteps % 2 == 0);
  if (outputs.feed_watchdog != 0) FeedWatchdog();
}

void Board::Maintain() noexcept {
  const std::uint32_t turn = steps_ / kMaintainSteps;
  if (turn == maintained_) return;
  maintained_ = turn;
  halls_.Maintain();
  if (all_asleep_) currents_.Maintain();
}

}  // namespace omni::board
