// The EEPROM of the chip.
#ifdef __AVR__

#include <avr/io.h>

#include "eeprom.h"
#include "lock.h"

bool eeprom::ready() { return !(EECR & _BV(EEPE)); }

uint8_t eeprom::read(uint16_t at) {
  EEAR = at;
  EECR |= _BV(EERE);
  return EEDR;
}

// The second bit must be set within four cycles of the first.
void eeprom::write(uint16_t at, uint8_t byte) {
  EEAR = at;
  EEDR = byte;
  const Lock lock;
  EECR = _BV(EEMPE);
  EECR |= _BV(EEPE);
}

#endif
