// This program drives the motor with a sequence of duties for 2 ms each: right, left, then with the pin
// directly.
#include "chip.h"
#include <util/delay.h>

int main(void) {
  static const uint8_t duty[] = {0, 1, 64, 128, 255};
  begin_pwm();
  for (uint8_t side = 0; side < 2; side++) {
    PORTB = side ? 0 : _BV(PB0);
    for (uint8_t i = 0; i < sizeof duty; i++) {
      OCR0B = duty[i];
      _delay_ms(2);
    }
  }
  TCCR0A = _BV(WGM00);  // the output is disconnected from the timer, so the pin's own level applies
  _delay_ms(2);
  PORTD = _BV(PD5);
  _delay_ms(2);
  DDRD = 0;
  rest();
}
