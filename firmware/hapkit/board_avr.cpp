// Clock and start of the Hapkit board, an ATmega328P at 16 MHz.
#ifdef __AVR__
#pragma GCC optimize("O2")  // also for what is included

#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "hardware.h"
#include "lock.h"
#include "profile.h"

namespace {

constexpr uint8_t kTicksPerUs = 1 / board::kTickUs;
constexpr uint16_t kQuarterUs = 250;

volatile uint32_t period_start_us = 0;
volatile uint16_t period_us = profile::kPeriodUs;  // the present one
volatile uint8_t quarters = 4;                     // in the present period
volatile uint8_t quarters_wanted = 4;              // in the next one
volatile uint16_t sampled_ticks = 0;               // when in its period the latest sample was taken
volatile bool sampling_busy = false;               // from the start of a reading to the end of its handling
volatile bool held = false;
volatile uint16_t periods = 0;                     // begun so far
volatile uint8_t missed = 0;                       // since the latest sample
board::Sampling sampling;                          // the latest one: untouched while it is handled

constexpr uint16_t ticks_of(uint16_t us) { return us * kTicksPerUs; }

// Timer 1 counts one sample period over and over: it is the clock and starts every sample.
void begin_clock() {
  TCCR1A = 0;
  TCCR1B = _BV(WGM12) | _BV(CS11);  // up to OCR1A, prescaler 8
  OCR1A = ticks_of(profile::kPeriodUs) - 1;
  TCNT1 = 0;
  TIFR1 = _BV(OCF1A);
  TIMSK1 = _BV(OCIE1A);
}

// The timer has just begun anew and is below every limit that it may get.
inline void change_period(uint8_t wanted) {
  const uint16_t us = wanted * kQuarterUs;
  quarters = wanted;
  period_us = us;
  OCR1A = ticks_of(us) - 1;
}

}  // namespace

// Starts a reading and notes when; the clock is read first, so the note is exact however late this runs.
ISR(TIMER1_COMPA_vect) {
  const uint16_t ticks = TCNT1;
  const uint32_t start = period_start_us + period_us;
  period_start_us = start;
  const uint16_t seq = periods + 1;
  periods = seq;
  const uint8_t ended = quarters, wanted = quarters_wanted;
  if (wanted != ended) change_period(wanted);
  if (sampling_busy) {
    missed = missed + 1;
    return;
  }
  hardware::start_reading();
  sampling_busy = true;
  sampled_ticks = ticks;
  sampling.seq = seq;
  sampling.time_us = start + ticks / kTicksPerUs;
  sampling.quarters = ended;
  sampling.missed = missed;
  missed = 0;
}

void hardware::reading_done(uint16_t raw, bool failed) {
  sampling.raw = raw;
  sampling.failed = failed;
  if (!held) board::on_sample(sampling);
  sampling_busy = false;
}

// In place of the Arduino core's, which starts timers as well and the interrupt of one. The converter is on because
// the first tick may come before there is a kit.
extern "C" void init() {
  ADCSRA = _BV(ADEN);
  sei();
}

void board::begin() {
  const Lock lock;
  hardware::begin_motor();
  hardware::begin_serial();
  begin_clock();
  hardware::begin_watchdog();
}

void board::configure(const protocol::Board& kit) {
  hardware::set_motor(kit);
  const Lock lock;
  hardware::set_sensor(kit);
  sampling_busy = false;
}

void board::hold(bool on) { held = on; }

void board::set_period(uint8_t wanted) { quarters_wanted = wanted; }

// Periods that began meanwhile have been counted as missed.
uint16_t board::age_us() {
  const Lock lock;
  const uint16_t ticks = TCNT1 - sampled_ticks;
  return ticks / kTicksPerUs + (missed ? missed * period_us : 0);
}

uint32_t board::now_us() {
  const Lock lock;
  const uint16_t ticks = TCNT1;
  uint32_t start = period_start_us;
  const uint16_t period = period_us;
  const bool wrapped = (TIFR1 & _BV(OCF1A)) && ticks < ticks_of(period) / 2;
  if (wrapped) start += period;
  return start + ticks / kTicksPerUs;
}

#endif
