// The same firmware for people who build with PlatformIO or Teensyduino: that core starts the chip and owns the vector
// table, everything else is firmware/board/teensy40. Its USB is off (USB_DISABLED) and ours uses the port, so the host
// sees the same base. To load another sketch afterwards, press the button.
//
// Two differences from the register-level image: the fault record is not kept across a reset, and a processor fault
// leads to a watchdog reset after 8 ms, not to immediate braking.
#include "firmware/board/teensy40/board.h"
#include "firmware/board/teensy40/boot/retained.h"
#include "firmware/board/teensy40/chip/chip.h"
#include "firmware/board/teensy40/chip/clocks.h"
#include "firmware/core/run.h"

// After ours, because it defines many macros.
#include <Arduino.h>

namespace {

using omni::board::Board;

Board* g_board = nullptr;
omni::firmware::Runner<Board>* g_runner = nullptr;

void OnControlStep() {
  if (omni::board::Timebase::AcknowledgeStep()) g_runner->Step();
}
void OnCurrentBus() { g_board->CurrentBusInterrupt(); }
void OnUsb() { g_board->UsbInterrupt(); }

}  // namespace

void setup() {
  using namespace omni::board;
  noInterrupts();
  OpenClockGates();
  SetUpPins();  // bridges asleep and braked before anything else
  SetUpPeripheralClocks();
  dwt::Start();
  static const omni::firmware::Settings settings = ChipSettings();
  static omni::firmware::FaultRecord record;
  static Board board(settings);
  static omni::firmware::Runner<Board> runner(board, settings, PopResetCause(false), dwt::Cycles(), record);
  g_board = &board;
  g_runner = &runner;
  attachInterruptVector(IRQ_PIT, OnControlStep);
  attachInterruptVector(IRQ_LPI2C1, OnCurrentBus);
  attachInterruptVector(IRQ_USB1, OnUsb);
  board.Start();
  StartWatchdog();
  interrupts();
}

void loop() { g_board->Maintain(); }
