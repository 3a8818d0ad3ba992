// What the files that know the chip (*_avr.cpp) ask of each other.
#pragma once

#include <stdint.h>

namespace hardware {

// Pins and timer of the motor, which is off.
void begin_motor();

// Everything the sensor needs.
void begin_sensor();

// Start one reading of the sensor; called with interrupts off, and never before the last one is done.
void start_reading();

// Called by the sensor when a reading is done, from an interrupt that lets other interrupts through.
void reading_done(uint16_t raw);

}  // namespace hardware
