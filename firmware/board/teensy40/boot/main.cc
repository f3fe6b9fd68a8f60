// The firmware of a base on a Teensy 4.0: start-up order, interrupt handlers, data kept across a reset.
#include "firmware/board/teensy40/board.h"
#include "firmware/board/teensy40/boot/memory_map.h"
#include "firmware/board/teensy40/boot/retained.h"
#include "firmware/board/teensy40/chip/chip.h"
#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/board/teensy40/chip/cpu.h"
#include "firmware/core/run.h"

namespace omni::board {
namespace {

Board* g_board = nullptr;
firmware::Runner<Board>* g_runner = nullptr;

static_assert(sizeof(Retained) <= kRetainedSize, "its place at the end of the on-chip RAM");
// Bytes, not a Retained: no constructor may overwrite the kept data.
__attribute__((section(".retained"), used)) alignas(Retained) unsigned char g_retained[sizeof(Retained)];

}  // namespace

Retained& retained() noexcept { return *reinterpret_cast<Retained*>(g_retained); }

firmware::ResetCause PopResetCause() noexcept {
  const bool crashed = retained().crashed == kCrashed;
  retained().crashed = 0;
  ++retained().resets;
  return PopResetCause(crashed);
}

}  // namespace omni::board

extern "C" {
void OnControlStep() {
  using omni::board::Timebase;
  if (Timebase::AcknowledgeStep()) omni::board::g_runner->Step();
}
void OnCurrentBus() { omni::board::g_board->CurrentBusInterrupt(); }
void OnUsb() { omni::board::g_board->UsbInterrupt(); }

int main() {
  using namespace omni::board;
  SetUpClocks();
  const omni::firmware::ResetCause cause = PopResetCause();
  static const omni::firmware::Settings settings = ChipSettings();
  static Board board(settings);
  static omni::firmware::Runner<Board> runner(board, settings, cause, retained().resets ^ dwt::Cycles(),
                                              retained().record);
  g_board = &board;
  g_runner = &runner;
  board.Start();
  StartWatchdog();
  InterruptsOn();
  for (;;) {
    WaitForInterrupt();
    board.Maintain();
  }
}
}
