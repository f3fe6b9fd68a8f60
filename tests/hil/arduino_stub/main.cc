// Teensyduino's part around a sketch, so that the check links: a vector table in RAM, and main.
#include <Arduino.h>

#include "firmware/board/teensy40/chip/cpu.h"

namespace {
void (*g_vectors[omni::board::kVectors])();
}

extern "C" void attachInterruptVector(IRQ_NUMBER_t irq, void (*function)(void)) {
  g_vectors[irq + omni::board::kCoreVectors] = function;
}

extern "C" [[noreturn]] void ResetHandler() {
  setup();
  for (;;) loop();
}
