// Firmware of the Hapkit board for Hapkit Studio. The program is in program.cpp; the chip is in the files *_avr.cpp.
#include "program.h"

void setup() { program::begin(); }

void loop() {
  for (;;) program::poll();
}
