// Settings of one kit: validated, in force, stored in the EEPROM.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace settings {

// The settings in force. They change only in the main program, while no sensor reading is processed, so
// the sample interrupt may read them at any time.
const protocol::Board& now();

// Their origin: protocol::kOriginDefault, kOriginStored, kOriginDamaged, kOriginUnsaved.
uint8_t origin();

// At the start, after board::begin(): apply the EEPROM's settings, or the defaults if it is empty
// or fails its check.
void load();

// Apply settings from the computer after switching the motor off; false, without changes, if a
// number is out of range. Main program only.
bool accept(const protocol::Board& wanted);

// Begin to store the settings in force in the EEPROM; unchanged bytes are not written. Main program only.
void save();

// True while a save is in progress; afterwards origin() is protocol::kOriginStored.
bool saving();

// Continue a save, 3.4 ms per byte, without waiting. Call it in every pass of the main program.
void poll();

}  // namespace settings
