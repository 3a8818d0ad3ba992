// The firmware of the Hapkit board for Hapkit Studio. program.cpp contains the program; the files *_avr.cpp
// contain the chip's part.
#include "program.h"

void setup() { program::begin(); }

void loop() {
  for (;;) program::poll();
}
