// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The baud rate that the computer has set at its end of the cable.
#pragma once

// Return the baud rate [bit/s] of the program that has the pseudo-terminal open; 0 if no program has it open.
unsigned line_speed(int fd);
