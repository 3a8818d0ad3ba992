// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Everything that starts the chip anew, and how the chip can tell.
#pragma once

#include "board.h"

// The supply comes on. adapter: the cable is a real one, opening the port resets and speeds must agree.
void reset_by_power(struct board *b, bool adapter);

// If the port has been opened since the last look and the cable is a real one.
void reset_by_cable(struct board *b);

// If the watchdog has expired.
void reset_by_watchdog(struct board *b);
