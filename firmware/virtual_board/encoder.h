// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// A quadrature encoder on D2 and D3, with edges at the cycle at which the handle passes them.
#pragma once

#include "board.h"

// Start at the handle's position; call after every reset, which releases the pins.
void encoder_reset(struct board *b);
