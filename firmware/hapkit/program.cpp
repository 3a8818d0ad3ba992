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
}

void program::poll() {
  uint8_t byte;
  while (board::read(&byte)) controller.receive(byte);
  settings::poll();
}
