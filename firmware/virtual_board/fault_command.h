// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Commands of two or more words that inject a fault, such as `to drop 0.01` or `sensor stuck 1`.
#pragma once

#include "board.h"

// Execute one line; return false if it is not one of these commands.
bool fault_command(struct board *b, const char *line);
