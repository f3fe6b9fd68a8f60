// The few calls of Teensyduino that the sketch makes, with their signatures [PaulStoffregen/cores, teensy4:
// core_pins.h, avr_functions.h, imxrt.h]; its interrupts' numbers are the chip's.
#pragma once

enum IRQ_NUMBER_t { IRQ_LPI2C1 = 28, IRQ_USB1 = 113, IRQ_PIT = 122 };

extern "C" void attachInterruptVector(IRQ_NUMBER_t irq, void (*function)(void));

#define noInterrupts() __asm__ volatile("CPSID i" ::: "memory")
#define interrupts() __asm__ volatile("CPSIE i" ::: "memory")

// Macros of Teensyduino that have collided with other names before.
#define bit(b) (1UL << (b))
#define word(...) Arduino_word(__VA_ARGS__)
#define F(string_literal) ((const char*)(string_literal))
#define PI 3.1415926535897932384626433832795
#define HIGH 1
#define LOW 0

void setup();
void loop();
