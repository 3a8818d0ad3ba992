// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "reset.h"

#include "line.h"
#include "reading.h"

enum { REG_MCUSR = 0x54, POWER_ON = 1 << 0, EXTERNAL = 1 << 1 };

static void settle_after_reset(struct board *b)
{
	b->avr->run_cycle_limit = CHUNK;
	uart_reset(&b->uart);
	b->started = false;
	b->off_since = 0;
	reading_reset(b);
	motor_read(&b->motor, b->avr->data);
	b->plant.motor = motor_force(&b->motor);
}

// After its watchdog has expired, simavr replaces its function `run` by one that resets the chip.
void reset_by_watchdog(struct board *b)
{
	if (b->avr->run == b->run_one)
		return;
	board_sync(b);
	b->avr->run(b->avr);
	settle_after_reset(b);
}

void board_reset(struct board *b)
{
	board_sync(b);
	avr_reset(b->avr);
	b->avr->data[REG_MCUSR] = EXTERNAL;
	settle_after_reset(b);
}

void reset_by_power(struct board *b, bool adapter)
{
	b->adapter = adapter;
	b->run_one = b->avr->run;
	b->avr->data[REG_MCUSR] = POWER_ON;
}

void reset_by_cable(struct board *b)
{
	if (!b->adapter)
		return;
	b->uart.line_speed = line_speed(b->link.fd);
	if (b->link.rang)
		board_reset(b);
	b->link.rang = false;
}
