// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// All causes of a reset, and the registers by which the chip distinguishes them.
#pragma once

#include "board.h"

// Power the board on. With adapter, the cable behaves like a real one: opening the port resets the board, and
// baud rates must agree.
void reset_by_power(struct board *b, bool adapter);

// Reset if the port has been opened since the last call and the cable behaves like a real one.
void reset_by_cable(struct board *b);

// Reset if the watchdog has expired.
void reset_by_watchdog(struct board *b);
