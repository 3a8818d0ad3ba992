// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Connects the sensor to the chip: by the converter, the SPI port or two pins.
#pragma once

#include "board.h"

// Connect the board's sensor. Call reading_reset after every reset of the chip.
void reading_attach(struct board *b);
void reading_reset(struct board *b);
