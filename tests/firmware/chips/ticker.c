// This program sends a frame of eleven bytes every millisecond.
#include "chip.h"
#include <util/delay.h>

int main(void) {
  begin_serial();
  TCCR1B = _BV(WGM12) | _BV(CS10);
  OCR1A = 15999;
  for (;;) {
    for (uint8_t i = 11; i > 0; i--) put(i - 1);
    while (!(TIFR1 & _BV(OCF1A))) {
    }
    TIFR1 = _BV(OCF1A);
  }
}
