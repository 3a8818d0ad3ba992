// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The chip's EEPROM, stored in a file between runs.
#pragma once

#include <sim_avr.h>

// Load the bytes of the EEPROM from a file; a missing file means an erased EEPROM. Exit with a message on
// failure.
void eeprom_load(avr_t *avr, const char *path);

// From here on, save the file shortly after the firmware has written, so that killing the program loses
// nothing. If path is NULL, never save.
void eeprom_keep(avr_t *avr, const char *path);

// Save the bytes to the file atomically, at once. If path is NULL, do not save.
void eeprom_save(avr_t *avr, const char *path);
