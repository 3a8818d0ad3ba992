// Switches the motor's output on in the mode of timer 2 that CONTROL_A and CONTROL_B say.
#include "chip.h"

int main(void) {
  DDRD = _BV(PD3);
  OCR2B = 10;
  TCCR2A = CONTROL_A;
  TCCR2B = CONTROL_B;
  rest();
}
