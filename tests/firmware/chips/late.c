// This program sends R when it is ready, then does not read received bytes for 3 ms. After that it returns
// the remaining bytes, and whether any byte was lost.
#include "chip.h"
#include <util/delay.h>

int main(void) {
  begin_serial();
  put('R');
  for (;;) {
    while (!(UCSR0A & _BV(RXC0))) {
    }
    _delay_ms(3);
    uint8_t lost = 0;
    while (UCSR0A & _BV(RXC0)) {
      lost |= UCSR0A & _BV(DOR0);
      put(UDR0);
    }
    put(lost ? '!' : '.');
  }
}
