#include "program.h"

#include "board.h"
#include "controller.h"
#include "settings.h"

namespace {
Controller controller;
}

void board::on_sample(const Sampling& sampling) { controller.sample(sampling); }

void program::begin() {
  board::begin();
  settings::load();
  controller.begin();
}

void program::poll() {
  uint8_t byte;
  while (!controller.due() && board::read(&byte)) controller.receive(byte);
  controller.poll();
  settings::poll();
  board::sleep_unless(controller.due());
}
