// Sends two bytes one right behind the other, with LOOK=1 once the port says that it has room; then its status when they
// have gone, how often the interrupt of the end came when it was let, the status in it and behind it, and the status
// after two more have gone and their flag was written away.
#include <util/delay.h>

#include "chip.h"

static volatile uint8_t served, inside;

ISR(USART_TX_vect) {
  served++;
  inside = UCSR0A;
}

static void two(uint8_t first, uint8_t second) {
  UDR0 = first;
#if LOOK
  while (!(UCSR0A & _BV(UDRE0))) {
  }
#endif
  UDR0 = second;
  _delay_us(40);
}

int main(void) {
  begin_serial();
  sei();
  two('1', '2');
  const uint8_t gone = UCSR0A;
  UCSR0B |= _BV(TXCIE0);
  _delay_us(5);
  const uint8_t behind = UCSR0A;
  UCSR0B &= ~_BV(TXCIE0);
  two('3', '4');
  UCSR0A = _BV(TXC0);
  const uint8_t cleared = UCSR0A;
  put(gone);
  put(served);
  put(inside);
  put(behind);
  put(cleared);
  rest();
}
