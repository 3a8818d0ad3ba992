// The small test programs share this file: the port runs at 1 Mbaud, the PWM as on the Hapkit.
#pragma once

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/sleep.h>
#include <stdint.h>

static inline void begin_serial(void) {
  UBRR0 = 0;
  UCSR0B = _BV(RXEN0) | _BV(TXEN0);
}

static inline uint8_t get(void) {
  while (!(UCSR0A & _BV(RXC0))) {
  }
  return UDR0;
}

static inline void put(uint8_t byte) {
  while (!(UCSR0A & _BV(UDRE0))) {
  }
  UDR0 = byte;
}

static inline void begin_clock(void) { TCCR1B = _BV(CS10); }

static inline void begin_pwm(void) {
  DDRD = _BV(PD5);
  DDRB = _BV(PB0);
  TCCR0A = _BV(COM0B1) | _BV(WGM00);
  TCCR0B = _BV(CS00);
}

static inline void rest(void) {
  sei();
  for (;;) sleep_mode();
}
