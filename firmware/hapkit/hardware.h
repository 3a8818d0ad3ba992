// What the files that know the chip (*_avr.cpp) ask of each other.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace hardware {

// After a reset, before anything is known of the kit: hold the motors of the usual board off.
void begin_motor();

// Motor off; then the pins and the timer that the kit's motor needs, everything else off.
void set_motor(const protocol::Board& kit);

// What the kit's sensor needs. A reading that was under way is gone. Interrupts are off.
void set_sensor(const protocol::Board& kit);

// Serial port, and sleep between its interrupts.
void begin_serial();

// Reset the board from now on after 15 ms without a pat.
void begin_watchdog();

// Start one reading of the sensor; called with interrupts off, and never before the last one is done.
void start_reading();

// Called by the sensor when a reading is done, from an interrupt that lets other interrupts through.
// failed: the sensor's own check says that it is wrong.
void reading_done(uint16_t raw, bool failed);

}  // namespace hardware
