// Says R when ready, takes 32 bytes at once and answers with the clock at which each was there, low byte first.
#include "chip.h"

int main(void) {
  static uint16_t clock[32];
  begin_serial();
  put('R');
  begin_clock();
  for (uint8_t i = 0; i < 32; i++) {
    get();
    clock[i] = TCNT1;
  }
  for (uint8_t i = 0; i < 32; i++) {
    put(clock[i] & 0xff);
    put(clock[i] >> 8);
  }
  rest();
}
