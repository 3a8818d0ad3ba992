// A fake EEPROM for the tests: its bytes, and the number of writes.
#pragma once

#include <array>
#include <cstdint>

namespace fake {

extern std::array<uint8_t, 1024> eeprom;
extern int eeprom_writes;
extern uint16_t eeprom_last;  // address of the last write
extern bool eeprom_busy;

// Erase everything and reset the write counters.
void erase_eeprom();

// Start the board with the present content of the EEPROM.
void power_on();

// Start a board with an erased EEPROM.
void fresh_board();

}  // namespace fake
