// The settings of one kit: they are validated, used, and stored in the EEPROM.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace settings {

// Return the present settings. They change only in the main program, while no sensor reading is processed,
// so the sample interrupt may read them at any time.
const protocol::Board& now();

// Return their origin: protocol::kOriginDefault, kOriginStored, kOriginDamaged, kOriginUnsaved.
uint8_t origin();

// At the start, after board::begin(): apply the settings in the EEPROM, or the defaults if it is empty or
// fails its check.
void load();

// Apply settings from the computer after switching the motor off. Return false without changes if a number is
// out of range. Call it only in the main program.
bool accept(const protocol::Board& wanted);

// Begin to store the present settings in the EEPROM; unchanged bytes are not written. Call it only in the
// main program.
void save();

// Return true while a save is in progress; afterwards origin() is protocol::kOriginStored.
bool saving();

// Continue a save without waiting; each byte takes 3.4 ms. Call it in every pass of the main program.
void poll();

}  // namespace settings
