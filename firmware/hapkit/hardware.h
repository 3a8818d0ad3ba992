// What the files that know the chip (*_avr.cpp) ask of each other.
#pragma once

#include <stdint.h>

#include "protocol.h"
#include "quadrature.h"

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

// Whether the sensor is the converter, which starts at this value of ADCSRA. Another one starts at the interrupt of
// OCR1B, with the encoder's steps as they are now.
extern volatile bool converts;
constexpr uint8_t kConvert = 0xcd;  // ADEN, ADSC, ADIE; 500 kHz
extern Quadrature encoder;
extern volatile uint16_t latched;

// Called by the sensor when a reading is done, from an interrupt that lets other interrupts through.
// failed: the sensor's own check says that it is wrong.
void reading_done(uint16_t raw, bool failed);

}  // namespace hardware
