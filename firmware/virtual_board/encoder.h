// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// A quadrature encoder on D2 and D3, which has its edges at the cycles at which the handle passes them.
#pragma once

#include "board.h"

// Start at the handle's position. Call this after every reset, because a reset releases the pins.
void encoder_reset(struct board *b);
