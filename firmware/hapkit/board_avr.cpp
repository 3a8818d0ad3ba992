// Clock and serial port of the Hapkit board, an ATmega328P at 16 MHz.
#ifdef __AVR__

#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "hardware.h"
#include "lock.h"
#include "profile.h"
#include "protocol.h"
#include "ring.h"

namespace {

constexpr uint32_t kCpu = 16000000;
constexpr uint8_t kTicksPerUs = 1 / board::kTickUs;
constexpr uint16_t kPeriodTicks = profile::kPeriodUs * kTicksPerUs;
constexpr uint16_t kBaudDivisor = kCpu / 16 / protocol::kBaud - 1;
static_assert((kBaudDivisor + 1) * 16 * protocol::kBaud == kCpu, "this baud rate is not exact");

Ring<64> received;
Ring<128> to_send;
volatile uint8_t lost = 0;

volatile uint32_t period_start_us = 0;
volatile bool sampling_busy = false;         // from the start of a reading to the end of its handling
board::Sampling sampling = {0, 0, 0, false, false};  // the latest one
volatile bool held = false;

// Timer 1 counts one sample period over and over: it is the clock and starts every sample.
void begin_clock() {
  TCCR1A = 0;
  TCCR1B = _BV(WGM12) | _BV(CS11);  // up to OCR1A, prescaler 8
  OCR1A = kPeriodTicks - 1;
  TCNT1 = 0;
  TIFR1 = _BV(OCF1A);
  TIMSK1 = _BV(OCIE1A);
}

void begin_serial() {
  UBRR0 = kBaudDivisor;
  UCSR0A = 0;
  UCSR0C = _BV(UCSZ01) | _BV(UCSZ00);
  UCSR0B = _BV(RXEN0) | _BV(TXEN0) | _BV(RXCIE0);
}

}  // namespace

// Starts a reading and notes when; the clock is read first, so the note is exact however late this runs.
ISR(TIMER1_COMPA_vect) {
  const uint16_t ticks = TCNT1;
  const uint32_t start = period_start_us + profile::kPeriodUs;
  period_start_us = start;
  sampling.seq++;
  if (sampling_busy) {
    sampling.overrun = true;
    return;
  }
  hardware::start_reading();
  sampling_busy = true;
  sampling.time_us = start + ticks / kTicksPerUs;
}

void hardware::reading_done(uint16_t raw, bool failed) {
  board::Sampling done;
  {
    const Lock lock;
    done = sampling;
    sampling.overrun = held;
  }
  done.raw = raw;
  done.failed = failed;
  if (!held) board::on_sample(done);
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
  hardware::begin_motor();
  begin_serial();
  begin_clock();
}

void board::configure(const protocol::Board& kit) {
  hardware::set_motor(kit);
  const Lock lock;
  hardware::set_sensor(kit);
  sampling_busy = false;
}

void board::hold(bool on) { held = on; }

bool board::read(uint8_t* byte) { return received.pop(byte); }

uint8_t board::room() { return to_send.room(); }

void board::send(const uint8_t* bytes, uint8_t size) {
  to_send.push(bytes, size);
  UCSR0B |= _BV(UDRIE0);
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
