#include "fake_eeprom.h"

#include "check.h"
#include "eeprom.h"
#include "fake_board.h"
#include "settings.h"

namespace fake {

std::array<uint8_t, 1024> eeprom;
int eeprom_writes = 0;
uint16_t eeprom_last = 0;
bool eeprom_busy = false;

void erase_eeprom() {
  eeprom.fill(eeprom::kErased);
  eeprom_writes = 0;
  eeprom_busy = false;
}

static const protocol::Board defaults = settings::now();  // the defaults, stored before any test

void power_on() {
  settings::accept(defaults);
  reset();
  settings::load();
}

void fresh_board() {
  erase_eeprom();
  power_on();
}

}  // namespace fake

bool eeprom::ready() { return !fake::eeprom_busy; }

uint8_t eeprom::read(uint16_t at) {
  CHECK(!fake::eeprom_busy);
  return fake::eeprom.at(at);
}

void eeprom::write(uint16_t at, uint8_t byte) {
  CHECK(!fake::eeprom_busy);
  fake::eeprom.at(at) = byte;
  fake::eeprom_last = at;
  ++fake::eeprom_writes;
}
