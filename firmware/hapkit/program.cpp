#include "program.h"

#include "board.h"
#include "controller.h"
#include "settings.h"

namespace {
Controller controller;
}

// For a test of the hardware watchdog, a build can hang 0.3 s after its start: 1 hangs in the tick, 2 in the
// main program.
#ifdef HAPKIT_HANG
void hang(uint8_t where) {
  while (where == HAPKIT_HANG && board::now_us() > 300000UL) {
  }
}
#else
inline void hang(uint8_t) {}
#endif

void board::on_sample(const Sampling& sampling) {
  hang(1);
  controller.sample(sampling);
}

void program::begin() {
  board::begin();
  settings::load();
  controller.begin();
}

void program::poll() {
  hang(2);
  board::may_sleep();
  uint8_t byte;
  while (!controller.due() && board::read(&byte)) controller.receive(byte);
  controller.poll();
  if (settings::saving()) settings::poll();
  board::sleep();
}
