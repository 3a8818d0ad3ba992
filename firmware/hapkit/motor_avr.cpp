// The pins of the L298 motor driver, on the default board and on board 1.0.
#ifdef __AVR__

#include <avr/io.h>

#include "board.h"
#include "hardware.h"
#include "lock.h"

namespace {

constexpr uint8_t kD3 = _BV(PD3);  // OC2B: enable of motor 1 on board 1.0; the encoder's pin on other boards
constexpr uint8_t kD5 = _BV(PD5);  // OC0B: enable of motor 1
constexpr uint8_t kD6 = _BV(PD6);  // enable of motor 2
constexpr uint8_t kD7 = _BV(PD7);
constexpr uint8_t kD8 = _BV(PB0);   // direction of motor 1
constexpr uint8_t kD11 = _BV(PB3);  // enable of motor 2 on board 1.0; data of an AS5048A on other boards
constexpr uint8_t kD12 = _BV(PB4);  // direction of motor 1 on board 1.0
constexpr uint8_t kD13 = _BV(PB5);

bool on_timer_2 = false;
bool high_is_right = true;

// Stop both timers and disconnect them from their pins, so that the ports' low level applies.
void stop_timers() {
  TCCR0A = TCCR0B = TIMSK0 = OCR0B = 0;
  TCCR2A = TCCR2B = TIMSK2 = OCR2B = 0;
}

// Hold pins low.
void hold_low(uint8_t on_port_d, uint8_t on_port_b) {
  PORTD &= ~on_port_d;
  DDRD |= on_port_d;
  PORTB &= ~on_port_b;
  DDRB |= on_port_b;
}

// All enables of both boards stay low, unless the pin belongs to a sensor. Direction pins of the other board
// may have a different function, such as a memory card.
void claim_pins(const protocol::Board& kit) {
  if (kit.pins == protocol::kPinsD3D12) return hold_low(kD3 | kD5 | kD6, kD11 | kD12 | kD13);
  const uint8_t d3 = kit.sensor == protocol::kSensorQuadrature ? 0 : kD3;
  const uint8_t d11 = kit.sensor == protocol::kSensorAs5048A ? 0 : kD11;
  hold_low(kD5 | kD6 | kD7 | d3, kD8 | d11);
}

// Phase-correct PWM without prescaler: 31.4 kHz is above hearing and below the 40 kHz of the L298. The
// overflow interrupt stays off, because it would take a fifth of the processor's time.
void start_timer() {
  if (on_timer_2) {
    TCCR2A = _BV(COM2B1) | _BV(WGM20);
    TCCR2B = _BV(CS20);
  } else {
    TCCR0A = _BV(COM0B1) | _BV(WGM00);
    TCCR0B = _BV(CS00);
  }
}

inline void set_pin(uint8_t pin, bool high) {
  if (high) {
    PORTB |= pin;
  } else {
    PORTB &= ~pin;
  }
}

}  // namespace

void hardware::begin_motor() {
  stop_timers();
  hold_low(kD5 | kD6 | kD7, kD8);
}

void hardware::set_motor(const protocol::Board& kit) {
  const Lock lock;
  stop_timers();
  DDRB &= ~(kD8 | kD11 | kD12 | kD13);
  DDRD &= ~kD3;
  claim_pins(kit);
  on_timer_2 = kit.pins == protocol::kPinsD3D12;
  high_is_right = kit.direction > 0;
  start_timer();
}

// The duty changes at the next PWM cycle, and the direction at once: they may be up to 32 us apart.
void board::set_motor(int16_t pwm) {
  const bool right = pwm >= 0;
  const uint8_t duty = static_cast<uint8_t>(right ? pwm : -pwm);
  const bool high = right == high_is_right;
  const Lock lock;
  if (on_timer_2) {
    OCR2B = duty;
    set_pin(kD12, high);
  } else {
    OCR0B = duty;
    set_pin(kD8, high);
  }
}

#endif
