// The sensor on A2.
#ifdef __AVR__

#include <avr/interrupt.h>
#include <avr/io.h>

#include "hardware.h"

namespace {

constexpr uint8_t kSensorChannel = 2;  // A2

}  // namespace

// 500 kHz: a conversion takes 26 us and keeps its ten bits within one count.
void hardware::begin_sensor() {
  ADMUX = _BV(REFS0) | kSensorChannel;
  ADCSRB = 0;
  DIDR0 = _BV(ADC2D);
  ADCSRA = _BV(ADEN) | _BV(ADIE) | _BV(ADPS2) | _BV(ADPS0);
}

void hardware::start_reading() { ADCSRA |= _BV(ADSC); }

// The conversion is done. Interrupts are on from the first instruction; the clock starts no second one meanwhile.
ISR(ADC_vect, ISR_NOBLOCK) { hardware::reading_done(ADC); }

#endif
