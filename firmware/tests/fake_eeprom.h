// The EEPROM as the tests see it: bytes, and how often they were written.
#pragma once

#include <array>
#include <cstdint>

namespace fake {

extern std::array<uint8_t, 1024> eeprom;
extern int eeprom_writes;
extern uint16_t eeprom_last;  // where the last write went
extern bool eeprom_busy;

// Erase everything and forget the writes.
void erase_eeprom();

// Start the board with what the EEPROM holds.
void power_on();

// Start a board that nobody has ever set.
void fresh_board();

}  // namespace fake
