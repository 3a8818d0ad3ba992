// Switches the motor's output on in the mode of timer TIMER, 0 or 2, that CONTROL_A and CONTROL_B say.
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
