#include "firmware/board/teensy40/timebase.h"

#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/board/teensy40/chip/registers.h"

namespace omni::board {
namespace {

// RM GPT, CR: clock 1 is the peripheral clock root, here the crystal; free run; capture 1 on falling edges.
constexpr std::uint32_t kReset = 1U << 15, kEnable = 1U, kFromZero = 1U << 1, kPeripheralClock = 1U << 6,
                        kFreeRun = 1U << 9;
constexpr std::uint32_t kRunInWait = 1U << 3, kRunInDebug = 1U << 2;
constexpr std::uint32_t kCapture1Falling = 2U << 16;
constexpr std::uint32_t kCaptured1 = 1U << 3;  // SR.IF1
constexpr std::uint32_t kAllFlags = 0x3F;
constexpr std::uint32_t kPerMicrosecond = kTimer_Hz / 1'000'000;

constexpr std::uint32_t kPitOn = 3;    // TCTRL: interrupt, run
constexpr std::uint32_t kPitFlag = 1;  // TFLG, written one clears

}  // namespace

void Timebase::Start(std::uint32_t step_us) noexcept {
  Gpt& timer = gpt2();
  timer.CR = 0;
  timer.CR = kReset;
  while ((timer.CR & kReset) != 0) {
  }
  timer.PR = kPerMicrosecond - 1;
  timer.IR = 0;
  timer.SR = kAllFlags;
  timer.CR = kPeripheralClock | kFreeRun | kFromZero | kRunInWait | kRunInDebug | kCapture1Falling;
  timer.CR |= kEnable;
  last_ = 0;
  high_ = 0;

  Pit& beat = pit();
  beat.MCR = 0;                                                // clock on
  for (PitChannel& channel : beat.channel) channel.TCTRL = 0;  // the ROM has used them
  beat.channel[0].LDVAL = step_us * kPerMicrosecond - 1;
  beat.channel[0].TFLG = kPitFlag;
  beat.channel[0].TCTRL = kPitOn;
}

std::uint64_t Timebase::Now() noexcept {
  const std::uint32_t now = NowLow32_us();
  if (now < last_) high_ += std::uint64_t{1} << 32;
  last_ = now;
  return high_ + now;
}

std::uint32_t Timebase::NowLow32_us() noexcept { return gpt2().CNT; }

bool Timebase::AcknowledgeStep() noexcept {
  PitChannel& channel = pit().channel[0];
  if ((channel.TFLG & kPitFlag) == 0) return false;
  channel.TFLG = kPitFlag;
  DataBarrier();  // otherwise the interrupt is entered twice, because the write arrives after the return
  return true;
}

bool Timebase::FanCapture::NextEdge(std::uint32_t& t_us) noexcept {
  Gpt& timer = gpt2();
  if ((timer.SR & kCaptured1) == 0) return false;
  t_us = timer.ICR1;
  timer.SR = kCaptured1;
  return true;
}

}  // namespace omni::board
