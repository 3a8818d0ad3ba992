// Switches the motor's output on in the timer mode that CONTROL_A and CONTROL_B say.
#include "chip.h"

int main(void) {
  DDRD = _BV(PD5);
  OCR0B = 10;
  TCCR0A = CONTROL_A;
  TCCR0B = CONTROL_B;
  rest();
}
