// This program sends two bytes back to back; with WAIT=1 it waits until the port reports free space. Then it
// sends the status after their transmission, the number of transmit-complete interrupts once they are
// enabled, the status inside and after the interrupt, and the status after two more bytes whose flag was
// cleared by writing.
#include <util/delay.h>

#include "chip.h"

static volatile uint8_t served, inside;

ISR(USART_TX_vect) {
  served++;
  inside = UCSR0A;
}

static void two(uint8_t first, uint8_t second) {
  UDR0 = first;
#if WAIT
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
