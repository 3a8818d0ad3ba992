// The EEPROM as the tests see it: bytes, how often they were written, and a power cut when the test wants one.
#pragma once

#include <array>
#include <cstdint>

namespace fake {

extern std::array<uint8_t, 1024> eeprom;
extern int eeprom_writes;
extern bool eeprom_busy;

// Erase everything and forget the writes.
void erase_eeprom();

}  // namespace fake
