// Non-volatile memory, implemented by eeprom_avr.cpp for the chip and by the tests.
#pragma once

#include <stdint.h>

namespace eeprom {

constexpr uint8_t kErased = 0xff;  // value of a byte that was never written

// True if the last write has finished. Until then, no other function may be called.
bool ready();

uint8_t read(uint16_t at);

// Begin to write a byte, which takes 3.4 ms; a power cut during it damages only this byte.
void write(uint16_t at, uint8_t byte);

}  // namespace eeprom
