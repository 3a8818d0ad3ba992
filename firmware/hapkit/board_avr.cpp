// The Hapkit board: ATmega328P at 16 MHz, L298 motor driver, sensor on A2. The only file that knows the chip.
#ifdef __AVR__

#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "lock.h"
#include "profile.h"
#include "protocol.h"
#include "ring.h"

namespace {

constexpr uint8_t kPwmPin = _BV(PD5);                     // OC0B, D5: enable of motor 1
constexpr uint8_t kSecondMotorPins = _BV(PD6) | _BV(PD7);  // D6, D7: held low, motor 2 stays off
constexpr uint8_t kDirPin = _BV(PB0);                     // D8: direction of motor 1
constexpr uint8_t kSensorChannel = 2;                     // A2

constexpr uint32_t kCpu = 16000000;
constexpr uint8_t kTicksPerUs = 1 / board::kTickUs;
constexpr uint16_t kPeriodTicks = profile::kPeriodUs * kTicksPerUs;
constexpr uint16_t kBaudDivisor = kCpu / 16 / protocol::kBaud - 1;
static_assert((kBaudDivisor + 1) * 16 * protocol::kBaud == kCpu, "this baud rate is not exact");

Ring<64> received;
Ring<128> to_send;
volatile uint8_t lost = 0;

volatile uint32_t period_start_us = 0;
volatile bool sampling_busy = false;         // from the start of a conversion to the end of its handling
board::Sampling sampling = {0, 0, 0, false};  // the latest one

// Phase-correct PWM without prescaler: 31.4 kHz, above hearing and below the 40 kHz of the L298.
// The overflow interrupt that the Arduino core started would take a fifth of the processor.
void begin_motor() {
  PORTD &= ~(kPwmPin | kSecondMotorPins);
  DDRD |= kPwmPin | kSecondMotorPins;
  DDRB |= kDirPin;
  OCR0B = 0;
  TCCR0A = _BV(COM0B1) | _BV(WGM00);
  TCCR0B = _BV(CS00);
  TIMSK0 = 0;
}

// Timer 1 counts one sample period over and over: it is the clock and starts every sample.
void begin_clock() {
  TCCR1A = 0;
  TCCR1B = _BV(WGM12) | _BV(CS11);  // up to OCR1A, prescaler 8
  OCR1A = kPeriodTicks - 1;
  TCNT1 = 0;
  TIFR1 = _BV(OCF1A);
  TIMSK1 = _BV(OCIE1A);
}

// 500 kHz: a conversion takes 26 us and keeps its ten bits within one count.
void begin_sensor() {
  ADMUX = _BV(REFS0) | kSensorChannel;
  ADCSRB = 0;
  DIDR0 = _BV(ADC2D);
  ADCSRA = _BV(ADEN) | _BV(ADIE) | _BV(ADPS2) | _BV(ADPS0);
}

void begin_serial() {
  UBRR0 = kBaudDivisor;
  UCSR0A = 0;
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

}  // namespace

// Starts a conversion and notes when; the clock is read first, so the note is exact however late this runs.
ISR(TIMER1_COMPA_vect) {
  const uint16_t ticks = TCNT1;
  const uint32_t start = period_start_us + profile::kPeriodUs;
  period_start_us = start;
  sampling.seq++;
  if (sampling_busy) {
    sampling.overrun = true;
    return;
  }
  ADCSRA |= _BV(ADSC);
  sampling_busy = true;
  sampling.time_us = start + ticks / kTicksPerUs;
}

// The conversion is done. Interrupts are on from the first instruction; sampling_busy keeps a second one away.
ISR(ADC_vect, ISR_NOBLOCK) {
  board::Sampling done;
  {
    const Lock lock;
    done = sampling;
    sampling.overrun = false;
  }
  done.raw = ADC;
  board::on_sample(done);
  sampling_busy = false;
}

ISR(USART_RX_vect) {
  const uint8_t damaged = UCSR0A & (_BV(FE0) | _BV(DOR0));
  if (!received.push(UDR0) || damaged) lost = lost + 1;
}

ISR(USART_UDRE_vect) {
  uint8_t byte;
  if (to_send.pop(&byte)) {
    UDR0 = byte;
  } else {
    UCSR0B &= ~_BV(UDRIE0);
  }
}

void board::begin() {
  const Lock lock;
  begin_motor();
  begin_sensor();
  begin_serial();
  begin_clock();
}

bool board::read(uint8_t* byte) { return received.pop(byte); }

uint8_t board::room() { return to_send.room(); }

void board::send(const uint8_t* bytes, uint8_t size) {
  to_send.push(bytes, size);
  UCSR0B |= _BV(UDRIE0);
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

uint32_t board::now_us() {
  const Lock lock;
  const uint16_t ticks = TCNT1;
  uint32_t start = period_start_us;
  const bool wrapped = (TIFR1 & _BV(OCF1A)) && ticks < kPeriodTicks / 2;
  if (wrapped) start += profile::kPeriodUs;
  return start + ticks / kTicksPerUs;
}

uint8_t board::lost_bytes() { return lost; }

#endif
