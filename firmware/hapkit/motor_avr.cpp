// Pins of the L298 motor driver.
#ifdef __AVR__

#include <avr/io.h>

#include "board.h"
#include "hardware.h"
#include "lock.h"
#include "profile.h"

namespace {

constexpr uint8_t kPwmPin = _BV(PD5);                     // OC0B, D5: enable of motor 1
constexpr uint8_t kSecondMotorPins = _BV(PD6) | _BV(PD7);  // D6, D7: held low, motor 2 stays off
constexpr uint8_t kDirPin = _BV(PB0);                     // D8: direction of motor 1

}  // namespace

// Phase-correct PWM without prescaler: 31.4 kHz, above hearing and below the 40 kHz of the L298.
// The overflow interrupt that the Arduino core started would take a fifth of the processor.
void hardware::begin_motor() {
  PORTD &= ~(kPwmPin | kSecondMotorPins);
  DDRD |= kPwmPin | kSecondMotorPins;
  DDRB |= kDirPin;
  OCR0B = 0;
  TCCR0A = _BV(COM0B1) | _BV(WGM00);
  TCCR0B = _BV(CS00);
  TIMSK0 = 0;
}

// The duty changes at the next turn of the PWM, the direction at once: up to 32 us apart.
void board::set_motor(int16_t pwm) {
  const bool right = pwm >= 0;
  const Lock lock;
  OCR0B = static_cast<uint8_t>(right ? pwm : -pwm);
  if (right == profile::kDirHighIsRight) {
    PORTB |= kDirPin;
  } else {
    PORTB &= ~kDirPin;
  }
}

#endif
