// Clock and start of the Hapkit board, an ATmega328P at 16 MHz.
#ifdef __AVR__
#pragma GCC optimize("O2")  // also for what is included

#include <avr/interrupt.h>
#include <avr/io.h>

#include "board.h"
#include "clock.h"
#include "hardware.h"
#include "lock.h"
#include "profile.h"

namespace {

constexpr uint8_t kTicksPerUs = 1 / board::kTickUs;
constexpr uint8_t kQuarterUs = 250;

constexpr uint16_t ticks_of(uint16_t us) { return us * kTicksPerUs; }
constexpr uint16_t top_of(uint8_t quarters) { return quarters * ticks_of(kQuarterUs) - 1; }

volatile uint8_t quarters = 4;  // of a millisecond in the present period
volatile uint8_t quarters_wanted = 4;  // in the next one
volatile uint16_t top_wanted = top_of(4);
volatile uint8_t sampling_busy = 0;  // from the start of a reading to the end of its handling; then what started it
static_assert(hardware::kConvert & _BV(OCIE1B), "either way of starting a reading sets this bit");
volatile bool held = false;
Clock board_clock;
board::Sampling sampling;                // the latest one: untouched while it is handled
volatile uint16_t sampled_ticks = 0;     // when in its period it was taken
volatile uint16_t sampled_quarters = 0;  // and what was before that period; wraps after 16 s
volatile uint8_t missed = 0;             // periods since then
volatile uint8_t missed_quarters = 0;

// Timer 1 counts one sample period over and over: it is the clock and starts every sample.
void begin_clock() {
  TCCR1A = 0;
  TCCR1B = _BV(WGM12) | _BV(CS11);  // up to OCR1A, prescaler 8
  OCR1A = ticks_of(profile::kPeriodUs) - 1;
  TCNT1 = 0;
  TIFR1 = _BV(OCF1A);
  TIMSK1 = _BV(OCIE1A);
}

}  // namespace

// Starts a reading and notes when; or notes what is missed. In assembler, because it runs in every period: 80 cycles
// where the compiler takes 140. The timer is below every limit that it may get, because it has just begun anew.
#define ADDRESS(name) [name] "i"(&name)
ISR(TIMER1_COMPA_vect, ISR_NAKED) {
  __asm__ volatile(
      "push r24\n\t"
      "in r24, __SREG__\n\t"
      "push r24\n\t"
      "push r25\n\t"
      "lds r24, %[quarters]\n\t"
      "lds r25, %[quarters_wanted]\n\t"
      "cpse r24, r25\n\t"
      "rjmp 6f\n"
      "1:\tlds r25, %[sampling_busy]\n\t"
      "sbrc r25, %[either]\n\t"
      "rjmp 7f\n\t"
      "lds r25, %[converts]\n\t"
      "sbrs r25, 0\n\t"
      "rjmp 8f\n\t"
      "ldi r25, %[convert]\n\t"
      "sts %[adcsra], r25\n"
      "2:\tsts %[sampling_busy], r25\n\t"
      "lds r25, %[tcnt1l]\n\t"
      "sts %[sampled_ticks], r25\n\t"
      "lds r25, %[tcnt1h]\n\t"
      "sts %[sampled_ticks]+1, r25\n\t"
      "sts %[sampling_quarters], r24\n\t"
      "lds r25, %[missed]\n\t"
      "sts %[sampling_missed], r25\n\t"
      "tst r25\n\t"
      "breq 3f\n\t"
      "rjmp 9f\n"
      "3:\tlds r25, %[sampled_quarters]\n\t"
      "add r25, r24\n\t"
      "sts %[sampled_quarters], r25\n\t"
      "brcc 4f\n\t"
      "lds r25, %[sampled_quarters]+1\n\t"
      "inc r25\n\t"
      "sts %[sampled_quarters]+1, r25\n"
      "4:\tlds r25, %[seq]\n\t"
      "inc r25\n\t"
      "sts %[seq], r25\n\t"
      "brne 5f\n\t"
      "lds r25, %[seq]+1\n\t"
      "inc r25\n\t"
      "sts %[seq]+1, r25\n"
      "5:\tpop r25\n\t"
      "pop r24\n\t"
      "out __SREG__, r24\n\t"
      "pop r24\n\t"
      "reti\n"
      "6:\tsts %[quarters], r25\n\t"  // the length of the period changes
      "lds r25, %[top_wanted]+1\n\t"
      "sts %[ocr1ah], r25\n\t"
      "lds r25, %[top_wanted]\n\t"
      "sts %[ocr1al], r25\n\t"
      "rjmp 1b\n"
      "7:\tlds r25, %[missed]\n\t"  // the last reading is still being handled
      "inc r25\n\t"
      "sts %[missed], r25\n\t"
      "lds r25, %[missed_quarters]\n\t"
      "add r25, r24\n\t"
      "sts %[missed_quarters], r25\n\t"
      "rjmp 5b\n"
      "8:\tlds r25, %[encoder]\n\t"  // no converter
      "sts %[latched], r25\n\t"
      "lds r25, %[encoder]+1\n\t"
      "sts %[latched]+1, r25\n\t"
      "lds r25, %[timsk1]\n\t"
      "ori r25, %[compare]\n\t"
      "sts %[timsk1], r25\n\t"
      "rjmp 2b\n"
      "9:\tlds r24, %[seq]\n\t"  // periods were missed
      "add r24, r25\n\t"
      "sts %[seq], r24\n\t"
      "clr r25\n\t"
      "sts %[missed], r25\n\t"
      "lds r24, %[seq]+1\n\t"
      "adc r24, r25\n\t"
      "sts %[seq]+1, r24\n\t"
      "lds r24, %[sampling_quarters]\n\t"
      "lds r25, %[missed_quarters]\n\t"
      "add r24, r25\n\t"
      "clr r25\n\t"
      "sts %[missed_quarters], r25\n\t"
      "rjmp 3b"
      :
      : ADDRESS(quarters), ADDRESS(quarters_wanted), ADDRESS(top_wanted), ADDRESS(sampling_busy), ADDRESS(missed),
        ADDRESS(missed_quarters), ADDRESS(sampled_ticks), ADDRESS(sampled_quarters), [seq] "i"(&sampling.seq),
        [sampling_quarters] "i"(&sampling.quarters), [sampling_missed] "i"(&sampling.missed),
        [converts] "i"(&hardware::converts), [encoder] "i"(&hardware::encoder), [latched] "i"(&hardware::latched),
        [convert] "i"(hardware::kConvert), [adcsra] "i"(_SFR_MEM_ADDR(ADCSRA)), [tcnt1l] "i"(_SFR_MEM_ADDR(TCNT1L)),
        [tcnt1h] "i"(_SFR_MEM_ADDR(TCNT1H)), [ocr1al] "i"(_SFR_MEM_ADDR(OCR1AL)),
        [ocr1ah] "i"(_SFR_MEM_ADDR(OCR1AH)), [timsk1] "i"(_SFR_MEM_ADDR(TIMSK1)), [compare] "M"(_BV(OCIE1B)), [either] "I"(OCIE1B)
      : "memory");
}

void hardware::reading_done(uint16_t raw, bool failed) {
  sampling.raw = raw;
  sampling.failed = failed;
  if (!held) board::on_sample(sampling);
  sampling_busy = 0;
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
  sampling_busy = 0;
}

void board::hold(bool on) { held = on; }

void board::set_period(uint8_t wanted) {
  const Lock lock;
  quarters_wanted = wanted;
  top_wanted = top_of(wanted);
}

static uint32_t stamp_of(uint16_t quarters_passed, uint16_t ticks) {
  return static_cast<uint32_t>(quarters_passed) << 16 | ticks;
}

uint32_t board::us_of(uint32_t stamp) { return board_clock.us_of(stamp); }

uint32_t board::stamp() { return stamp_of(sampled_quarters, sampled_ticks); }

// Periods that began meanwhile have been counted as missed.
uint16_t board::age_us() {
  const Lock lock;
  uint16_t ticks = TCNT1 - sampled_ticks;
  if (missed) ticks += missed_quarters * ticks_of(kQuarterUs);
  return ticks / kTicksPerUs;
}

uint32_t board::now_us() {
  const Lock lock;
  const uint16_t ticks = TCNT1;
  uint16_t passed = sampled_quarters + missed_quarters;
  const bool wrapped = (TIFR1 & _BV(OCF1A)) && ticks < ticks_of(kQuarterUs) / 2;
  if (wrapped) passed += quarters;
  return us_of(stamp_of(passed, ticks));
}

#endif
