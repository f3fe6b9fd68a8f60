// How many instructions a piece of code takes. SysTick runs at 25 MHz of emulated time; with `-icount shift=N` every
// instruction takes 2^N ns of it, so that the count is exact and the same on every machine. The counter measures the
// rate itself. Without -icount emulated time is the host's, and the figures mean nothing.
#pragma once

#include <cstdint>

#include "firmware/board/mps2_an500/text.h"
#include "firmware/wire/messages.h"

namespace omni::firmware::board {

class InstructionCounter {
 public:
  // Starts SysTick [ARMv7-M, B3.3] and measures code of known length.
  InstructionCounter() noexcept;

  void Begin() noexcept;
  // Since Begin. At most 2^24 ticks, at shift=10 650,000 instructions: more comes out smaller.
  std::uint32_t End() const noexcept;

  // Ticks of 1024 instructions; 0: not measured.
  std::uint32_t rate() const noexcept { return ticks_of_1024_; }

 private:
  std::uint32_t Elapsed() const noexcept;

  std::uint32_t begin_ = 0;
  std::uint32_t ticks_of_nothing_ = 0;
  std::uint32_t ticks_of_1024_ = 0;
};

// Instructions of control steps by the core's state, for steps without and with a frame to send.
class StepCounts {
 public:
  void Add(wire::State state, bool sent_frame, std::uint32_t instructions) noexcept {
    if (static_cast<std::size_t>(state) >= kStates) return;
    Count& count = counts_[static_cast<std::size_t>(state)][sent_frame ? 1 : 0];
    ++count.steps;
    count.sum += instructions;
    if (instructions > count.most) count.most = instructions;
  }

  // Lines "armed_telemetry_steps 100", "..._mean 2000", "..._most 2500" for the states that occurred.
  void Write(Text& report) const noexcept {
    static constexpr const char* kNames[kStates][2] = {{"boot_", "boot_telemetry_"},
                                                       {"self_test_", "self_test_telemetry_"},
                                                       {"idle_", "idle_telemetry_"},
                                                       {"armed_", "armed_telemetry_"},
                                                       {"fault_", "fault_telemetry_"}};
    for (std::size_t state = 0; state < kStates; ++state) {
      for (std::size_t kind = 0; kind < 2; ++kind) {
        const Count& count = counts_[state][kind];
        if (count.steps == 0) continue;
        const char* name = kNames[state][kind];
        report.Add(name).Add("steps ").Add(count.steps).Add("\n");
        report.Add(name).Add("mean ").Add(static_cast<std::uint32_t>(count.sum / count.steps)).Add("\n");
        report.Add(name).Add("most ").Add(count.most).Add("\n");
      }
    }
  }

 private:
  static constexpr std::size_t kStates = static_cast<std::size_t>(wire::State::kFault) + 1;
  struct Count {
    std::uint32_t steps = 0, most = 0;
    std::uint64_t sum = 0;
  };
  Count counts_[kStates][2];
};

}  // namespace omni::firmware::board
