// The clock and the start of the Hapkit board, an ATmega328P at 16 MHz.
#ifdef __AVR__
#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "clock.h"
#include "hardware.h"
#include "lock.h"
#include "profile.h"

namespace {

constexpr uint8_t kTicksPerUs = 1 / board::kTickUs;
constexpr uint16_t kUsual = profile::kPeriodUs * kTicksPerUs;

volatile uint16_t period = kUsual;         // duration of the current period, in ticks
volatile uint16_t period_wanted = kUsual;  // duration of the next period
volatile bool sampling_busy = false;  // true from the start of a reading until it has been handled
volatile bool held = false;
Clock board_clock;
board::Sampling sampling;         // the newest sampling; it does not change while it is processed
volatile uint16_t passed = 0;     // ticks before the current period, lower half
volatile uint16_t wraps = 0;      // ticks before the current period, upper half
volatile uint8_t missed = 0;      // periods since the newest sampling
uint16_t sampled = 0;             // time of the newest sampling, lower half of the ticks

// Timer 1 counts one sample period repeatedly. It is the clock, and it starts every sample.
void begin_clock() {
  TCCR1A = 0;
  TCCR1B = _BV(WGM12) | _BV(CS11);  // count up to OCR1A, prescaler 8
  OCR1A = kUsual - 1;
  TCNT1 = 0;
  TIFR1 = _BV(OCF1A);
  TIMSK1 = _BV(OCIE1A);
}

}  // namespace

// Start a reading and store its time, or count a missed reading. The timer is below any new limit, because it
// has just restarted.
ISR(TIMER1_COMPA_vect) {
  const uint16_t ended = period;
  const uint16_t now = passed + ended;
  passed = now;
  if (now < ended) wraps = wraps + 1;
  if (ended != period_wanted) {
    period = period_wanted;
    OCR1A = period - 1;
  }
  if (sampling_busy) {
    missed = missed + 1;
    return;
  }
  if (hardware::converts) {
    ADCSRA = hardware::kConvert;
  } else {
    hardware::latched = hardware::encoder.steps();
    TIMSK1 |= _BV(OCIE1B);
  }
  sampling_busy = true;
  sampled = now + TCNT1;
  sampling.ticks = ended;
  sampling.missed = missed;
  missed = 0;
}

void hardware::reading_done(uint16_t raw, bool failed) {
  sampling.seq += 1 + sampling.missed;
  sampling.raw = raw;
  sampling.failed = failed;
  if (!held) board::on_sample(sampling);
  sampling_busy = false;
}

// Replaces the init of the Arduino core, which also starts timers and an interrupt. The converter is switched
// on because the first tick may come before the kit is known.
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
  sampling_busy = 0;
}

void board::hold(bool on) { held = on; }

void board::set_period(uint16_t ticks) {
  const Lock lock;
  period_wanted = ticks;
}

// Return the ticks before the present period; interrupts must be off.
static uint32_t all_passed() { return static_cast<uint32_t>(wraps) << 16 | passed; }

uint32_t board::us_of(uint32_t stamp) { return board_clock.us_of(stamp); }

// The difference fits into 16 bits, because the sample is less than 16 ms from the start of the present period.
uint32_t board::stamp() {
  const Lock lock;
  return all_passed() + static_cast<int16_t>(sampled - passed);
}

// The difference includes the periods that have started since the sample.
uint16_t board::age_us() {
  const Lock lock;
  const uint16_t ticks = TCNT1 + passed - sampled;
  return ticks / kTicksPerUs;
}

uint32_t board::now_us() {
  const Lock lock;
  const uint16_t ticks = TCNT1;
  uint32_t before = all_passed();
  const bool wrapped = (TIFR1 & _BV(OCF1A)) && ticks < board::kShortest / 2;
  if (wrapped) before += period;
  return us_of(before + ticks);
}

#endif
