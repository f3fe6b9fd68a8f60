#include "firmware/board/teensy40/sensors/thermometer.h"

#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {
namespace {
constexpr std::int32_t kRoom_C = 25;  // the first point of the factory's calibration; the second is in the fuses
constexpr std::uint32_t kMeasureEvery = 0x100;  // ticks of 32.768 kHz: 8 ms
}  // namespace

void Thermometer::Start() noexcept {
  const std::uint32_t fuse = Word(kFuseThermometer);
  room_count_ = static_cast<std::int32_t>(fuse >> 20);
  hot_count_ = static_cast<std::int32_t>(fuse >> 8 & 0xFFF);
  hot_C_ = static_cast<std::int32_t>(fuse & 0xFF);
  analog().TEMPSENSE0.clear = analog_bits::kTempPowerDown;
  analog().TEMPSENSE1.value = kMeasureEvery;
  analog().TEMPSENSE0.set = analog_bits::kTempMeasure;
}

// T = hot - (count - hot_count) (hot - 25) / (room_count - hot_count)   [RM TEMPMON, temperature equation]
std::int16_t Thermometer::Read() noexcept {
  const std::uint32_t value = analog().TEMPSENSE0.value;
  const std::int32_t span = room_count_ - hot_count_;
  if ((value & analog_bits::kTempFinished) == 0 || span <= 0) return last_;
  const auto count = static_cast<std::int32_t>(value >> 8 & 0xFFF);
  last_ = static_cast<std::int16_t>(100 * hot_C_ - 100 * (count - hot_count_) * (hot_C_ - kRoom_C) / span);
  return last_;
}

}  // namespace omni::board
