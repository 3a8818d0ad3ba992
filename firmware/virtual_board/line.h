// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The speed that the computer has set its end of the cable to.
#pragma once

// Return the bit/s of whoever has the pseudo-terminal open, 0 if nobody has.
unsigned line_speed(int fd);
