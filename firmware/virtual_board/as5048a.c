// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "as5048a.h"

enum { READ = 1 << 14, ERROR = 1 << 14, PARITY = 1 << 15, DATA = 0x3fff };
enum { CLEAR_ERROR = 0x0001, HEALTH = 0x3ffd, ANGLE = 0x3fff };
enum { OFFSETS_DONE = 1 << 8, GAIN = 0x80 };

static bool even(uint16_t frame)
{
	return !(__builtin_popcount(frame) & 1);
}

static uint16_t value_of(struct as5048a *d)
{
	switch (d->command & DATA) {
	case ANGLE:
		return (uint16_t)d->angle(d->outside);
	case HEALTH:
		return OFFSETS_DONE | GAIN;
	case CLEAR_ERROR:
		return 1 << 2;  // the error is a parity error
	default:
		return 0;
	}
}

static double chance(uint64_t *state)
{
	*state = *state * 6364136223846793005u + 1442695040888963407u;
	return (double)(*state >> 11) * 0x1p-53;
}

static void prepare(struct as5048a *d)
{
	uint16_t frame = value_of(d) & DATA;
	if ((d->command & DATA) == CLEAR_ERROR)
		d->error = false;
	if (d->error)
		frame |= ERROR;
	if (!even(frame))
		frame |= PARITY;
	if (d->flip > 0.0 && chance(&d->random) < d->flip) {
		frame ^= (uint16_t)(1u << (int)(16.0 * chance(&d->random)));
		d->turned++;
	}
	d->answer = frame;
}

void as5048a_select(void *device, bool selected)
{
	struct as5048a *d = device;
	if (selected) {
		prepare(d);
		d->command = 0;
		d->bytes = 0;
		return;
	}
	if (d->bytes && (d->bytes != 2 || !even(d->command) || !(d->command & READ)))
		d->error = true;
	d->frames++;
}

uint8_t as5048a_exchange(void *device, uint8_t byte)
{
	struct as5048a *d = device;
	uint8_t back = d->bytes == 0 ? (uint8_t)(d->answer >> 8) : (uint8_t)d->answer;
	d->command = (uint16_t)(d->command << 8 | byte);
	d->bytes++;
	return d->absent ? 0xff : back;
}
