// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "line.h"

// This is in a separate file, because these headers and <termios.h> define the same structure differently.
// Only these headers report baud rates that have no named constant.
#include <asm/termbits.h>
#include <asm/ioctls.h>

extern int ioctl(int fd, unsigned long request, ...);

unsigned line_speed(int fd)
{
	struct termios2 t;
	return fd >= 0 && ioctl(fd, TCGETS2, &t) == 0 ? t.c_ospeed : 0;
}
