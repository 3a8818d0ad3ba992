// Says R when ready; for every two floats of four bytes, low byte first, answers with their product, or what OP makes of them.
#include "chip.h"

#ifndef OP
#define OP *
#endif

static float read(void) {
  union { float number; uint8_t bytes[4]; } got;
  for (uint8_t i = 0; i < 4; i++) got.bytes[i] = get();
  return got.number;
}

int main(void) {
  begin_serial();
  put('R');
  for (;;) {
    union { volatile float number; uint8_t bytes[4]; } product;
    const float a = read();
    put('A');
    const float b = read();
    product.number = a OP b;
    for (uint8_t i = 0; i < 4; i++) put(product.bytes[i]);
  }
}
