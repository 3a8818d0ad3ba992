// Everything about one kit that changes without a new firmware: checked, in force, kept in the EEPROM.
#pragma once

#include <stdint.h>

#include "protocol.h"

namespace settings {

// The settings in force. They change only in the main program, while no reading of the sensor is handled, so
// the sample interrupt may read them at any time.
const protocol::Board& now();

// Where they come from: protocol::kOriginDefault, kOriginStored, kOriginDamaged, kOriginUnsaved.
uint8_t origin();

// At the start, after board::begin(): put in force what the EEPROM holds, the defaults where it holds nothing
// or where its check fails.
void load();

// Put in force, after switching the motor off, what the computer sends; false, and nothing is changed, if a
// number is not one that a kit has. Main program only.
bool accept(const protocol::Board& wanted);

// Begin to keep in the EEPROM what is in force; nothing is written that is there already. Main program only.
void save();

// Whether save() has not come to its end yet; then origin() becomes protocol::kOriginStored.
bool saving();

// Go on with save(), a byte of 3.4 ms at a time and without waiting. Call it in every turn of the main program.
void poll();

}  // namespace settings
