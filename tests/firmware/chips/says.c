// Says the same thing over and over, 2 ms apart.
#include "chip.h"
#include <util/delay.h>

static const uint8_t said[] = {
#include <said.h>
};

int main(void) {
  begin_serial();
  for (;;) {
    for (uint16_t i = 0; i < sizeof said; i++) put(said[i]);
    _delay_ms(2);
  }
}
