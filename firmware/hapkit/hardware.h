// The interface between the files that depend on the chip (*_avr.cpp).
#pragma once

#include <stdint.h>

#include "protocol.h"
#include "quadrature.h"

namespace hardware {

// After a reset, before the kit is known: keep the motors of the default board off.
void begin_motor();

// Turn the motor off, then set the kit's motor pins and timer; all other outputs stay off.
void set_motor(const protocol::Board& kit);

// Initialise the kit's sensor. A reading in progress is lost. Interrupts must be off.
void set_sensor(const protocol::Board& kit);

// Set up the serial port, and sleep between its interrupts.
void begin_serial();

// From here on, reset the board after 15 ms without feeding.
void begin_watchdog();

// True if the analog-to-digital converter reads the sensor; writing kConvert to ADCSRA starts a conversion.
// The interrupt of OCR1B starts a reading of any other sensor. The encoder's steps are in latched.
extern volatile bool converts;
constexpr uint8_t kConvert = 0xcd;  // ADEN, ADSC, ADIE; 500 kHz
extern Quadrature encoder;
extern volatile uint16_t latched;

// The sensor calls this when a reading is complete, from an interrupt during which other interrupts are
// enabled. failed: the sensor itself reports that the reading is invalid.
void reading_done(uint16_t raw, bool failed);

}  // namespace hardware
