// The angle sensors on the chip: the converter on A2, an AS5048A on the SPI bus, an encoder on D2 and D3.
#ifdef __AVR__

#include <avr/interrupt.h>
#include <avr/io.h>

#include "as5048a.h"
#include "hardware.h"
#include "quadrature.h"

namespace {

constexpr uint8_t kChannel = 2;          // A2
constexpr uint8_t kSelect = _BV(PB2);    // D10, which selects the AS5048A while it is low
constexpr uint8_t kBusOut = _BV(PB3) | _BV(PB5);  // D11, D13
constexpr uint8_t kBusIn = _BV(PB4);     // D12
constexpr uint8_t kEncoder = _BV(PD2) | _BV(PD3);
constexpr uint8_t kSpi = _BV(SPE) | _BV(MSTR) | _BV(CPHA);  // 4 MHz; data are sampled at the falling edge

As5048A angle;

void all_off() {
  ADCSRA = 0;
  SPCR = 0;
  EIMSK = 0;
  TIMSK1 &= ~_BV(OCIE1B);
  DIDR0 = 0;
}

// At 500 kHz a conversion takes 26 us, and its ten bits are accurate to one count.
void begin_converter() {
  ADMUX = _BV(REFS0) | kChannel;
  ADCSRB = 0;
  DIDR0 = _BV(ADC2D);
  ADCSRA = (hardware::kConvert & ~_BV(ADSC)) | _BV(ADIF);
}

// With the pull-up a missing sensor replies with ones, which is an error.
void begin_bus() {
  PORTB |= kSelect | kBusIn;
  DDRB |= kSelect | kBusOut;
  SPSR = 0;
  SPCR = kSpi;
  angle = As5048A();
}

void begin_encoder() {
  PORTD |= kEncoder;
  DDRD &= ~kEncoder;
  hardware::encoder.start(PIND & kEncoder);
  EICRA = _BV(ISC00) | _BV(ISC10);  // interrupt at every edge
  EIFR = _BV(INTF0) | _BV(INTF1);
  EIMSK = _BV(INT0) | _BV(INT1);
}

uint8_t byte_back() {
  while (!(SPSR & _BV(SPIF))) {
  }
  return SPDR;
}

// Exchange two bytes in both directions; the first one is complete.
uint16_t finish_frame(uint8_t high, uint8_t second) {
  SPDR = second;
  const uint8_t low = byte_back();
  PORTB |= kSelect;
  return static_cast<uint16_t>(high << 8) | low;
}

// The sensor needs 350 ns between selection and clock, and between two frames.
void begin_frame(uint8_t first) {
  __builtin_avr_delay_cycles(6);
  PORTB &= ~kSelect;
  __builtin_avr_delay_cycles(4);
  SPDR = first;
}

}  // namespace

volatile bool hardware::converts = true;
Quadrature hardware::encoder;
volatile uint16_t hardware::latched;

// Timer 1 reaches OCR1B just after the start of a period, so its interrupt follows at once.
void hardware::set_sensor(const protocol::Board& kit) {
  all_off();
  converts = kit.sensor == protocol::kSensorMagnetoresistive;
  OCR1B = 0;
  if (converts) {
    begin_converter();
  } else if (kit.sensor == protocol::kSensorAs5048A) {
    begin_bus();
  } else {
    begin_encoder();
  }
}

// For all three sensors, interrupts are enabled at or near the first instruction; no other reading starts
// meanwhile.
ISR(ADC_vect, ISR_NOBLOCK) { hardware::reading_done(ADC, false); }

ISR(TIMER1_COMPB_vect) {
  TIMSK1 &= ~_BV(OCIE1B);
  if (SPCR) {
    SPCR = kSpi | _BV(SPIE);
    return begin_frame(As5048A::kReadAngle >> 8);
  }
  sei();
  hardware::reading_done(hardware::latched, hardware::encoder.take_slip());
}

// The first byte is complete. A reply comes in the frame after its request.
ISR(SPI_STC_vect, ISR_NOBLOCK) {
  SPCR = kSpi;
  const uint16_t health = finish_frame(SPDR, static_cast<uint8_t>(As5048A::kReadAngle));
  const uint16_t question = angle.next();
  begin_frame(question >> 8);
  const uint16_t answer = finish_frame(byte_back(), static_cast<uint8_t>(question));
  const bool good = angle.take(health, answer);
  hardware::reading_done(angle.reading(), !good);
}

ISR(INT0_vect) { hardware::encoder.edge(PIND & kEncoder); }

ISR(INT1_vect, ISR_ALIASOF(INT0_vect));

#endif
