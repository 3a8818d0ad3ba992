// This program sends bytes as fast as the port permits.
#include "chip.h"

int main(void) {
  begin_serial();
  for (uint8_t i = 1;; i++) put(i);
}
