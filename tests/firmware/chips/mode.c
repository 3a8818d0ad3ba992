// This program enables the motor's output in the mode of timer TIMER (0 or 2) given by CONTROL_A and
// CONTROL_B.
#include "chip.h"

int main(void) {
#if TIMER == 0
  DDRD = _BV(PD5);
  OCR0B = 10;
  TCCR0A = CONTROL_A;
  TCCR0B = CONTROL_B;
#else
  DDRD = _BV(PD3);
  OCR2B = 10;
  TCCR2A = CONTROL_A;
  TCCR2B = CONTROL_B;
#endif
  rest();
}
