// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The chip's EEPROM, kept in a file from run to run.
#pragma once

#include <sim_avr.h>

// Take its bytes from a file; one that is not there yet is an erased EEPROM. Exits with a message if it fails.
void eeprom_load(avr_t *avr, const char *path);

// From now on write the file whenever the firmware has written, a little later: whoever kills the program
// loses nothing. Path NULL: nothing is kept.
void eeprom_keep(avr_t *avr, const char *path);

// Write its bytes to the file as a whole, at once. Path NULL: nothing is kept.
void eeprom_save(avr_t *avr, const char *path);
