// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Create the chip and load a firmware into it.
#pragma once

#include <sim_avr.h>

// Return an ATmega328P with the .elf or .hex file loaded. Exit with a message on failure.
avr_t *load_firmware(const char *path, uint32_t frequency, uint32_t millivolts);

// Load a boot loader (.hex) in addition to the firmware; every reset then starts the boot loader.
void load_bootloader(avr_t *avr, const char *path);
