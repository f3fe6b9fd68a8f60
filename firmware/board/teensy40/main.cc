// The firmware of a base on a Teensy 4.0: what to call when.
#include <cstdint>

#include "firmware/board/teensy40/board.h"
#include "firmware/board/teensy40/clocks.h"
#include "firmware/board/teensy40/cpu.h"
#include "firmware/board/teensy40/retained.h"
#include "firmware/board/teensy40/watchdog.h"
#include "firmware/core/run.h"

namespace omni::board {
namespace {

// "omni-" and the low 40 bits of the chip's own number.
void NameAfterChip(char (&serial)[16]) noexcept {
  constexpr char kDigits[] = "0123456789abcdef";
  const std::uint64_t number = std::uint64_t{Word(kFuseUnique1)} << 32 | Word(kFuseUnique0);
  constexpr char kPrefix[] = {'o', 'm', 'n', 'i', '-'};
  for (int i = 0; i < 5; ++i) serial[i] = kPrefix[i];
  for (int i = 0; i < 10; ++i) serial[5 + i] = kDigits[number >> (36 - 4 * i) & 0xF];
  serial[15] = 0;
}

firmware::Settings BoardSettings() noexcept {
  firmware::Settings settings;
  NameAfterChip(settings.serial);
  return settings;
}

Board* g_board = nullptr;
firmware::Runner<Board>* g_runner = nullptr;

}  // namespace
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
  const omni::firmware::ResetCause cause = TakeResetCause();
  static const omni::firmware::Settings settings = BoardSettings();
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
