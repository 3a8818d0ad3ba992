// This program sends R when it is ready, receives 32 bytes, and returns the clock at which each arrived, low
// byte first.
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
