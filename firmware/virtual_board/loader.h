// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Make the chip and put a firmware into it.
#pragma once

#include <sim_avr.h>

// Return an ATmega328P holding the .elf or .hex file. Exits with a message if that cannot be.
avr_t *load_firmware(const char *path, uint32_t frequency, uint32_t millivolts);

// Put a bootloader (.hex) beside the firmware; from now on every reset begins with it.
void load_bootloader(avr_t *avr, const char *path);
