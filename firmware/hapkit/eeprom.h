// The non-volatile memory, which eeprom_avr.cpp implements for the chip and the tests implement for a PC.
#pragma once

#include <stdint.h>

namespace eeprom {

constexpr uint8_t kErased = 0xff;  // value of a byte that was never written

// Return true if the last write has finished. Until then, no other function may be called.
bool ready();

uint8_t read(uint16_t at);

// Begin to write a byte, which takes 3.4 ms. If the power is cut during this time, only this byte is damaged.
void write(uint16_t at, uint8_t byte);

}  // namespace eeprom
