// Sleeps a hundred times without having allowed it, then tells how many cycles that took, low byte first.
#include "chip.h"

int main(void) {
  begin_serial();
  sei();
  begin_clock();
  for (uint8_t i = 0; i < 100; i++) sleep_cpu();
  const uint16_t clock = TCNT1;
  put(clock & 0xff);
  put(clock >> 8);
  rest();
}
