// Interface between the files that depend on the chip (*_avr.cpp).
#pragma once

#include <stdint.h>

#include "protocol.h"
#include "quadrature.h"

namespace hardware {

// After a reset, before the kit is known: keep the motors of the usual board off.
void begin_motor();

// Motor off; then set the kit's motor pins and timer, everything else off.
void set_motor(const protocol::Board& kit);

// Initialise the kit's sensor. A reading in progress is lost. Interrupts are off.
void set_sensor(const protocol::Board& kit);

// Serial port, and sleep between its interrupts.
void begin_serial();

// Reset the board from now on after 15 ms without feeding.
void begin_watchdog();

// True if the sensor is the converter, started by this value of ADCSRA. Others start in the interrupt of
// OCR1B, with the encoder's present steps.
extern volatile bool converts;
constexpr uint8_t kConvert = 0xcd;  // ADEN, ADSC, ADIE; 500 kHz
extern Quadrature encoder;
extern volatile uint16_t latched;

// Called by the sensor when a reading is done, from an interrupt that lets other interrupts through.
// failed: the sensor's own check reports an invalid reading.
void reading_done(uint16_t raw, bool failed);

}  // namespace hardware
