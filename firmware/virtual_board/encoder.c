// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The handle is checked so often that no two edges fall between two checks. If a script moves the handle by a
// jump, there may be several edges between two checks; they then follow each other at intervals that the chip
// can handle.

#include "encoder.h"

#include <avr_ioport.h>
#include <math.h>

enum { SHORTEST = 32, LONGEST = 256, FIRST_PIN = 2 };
#define FASTEST_CHANGE 0.05  // [m/s] possible change of the speed until the next check

static void drive(struct board *b)
{
	static const uint8_t PLACES[] = {0, 1, 3, 2};
	uint8_t level = PLACES[b->steps & 3];
	avr_ioport_external_t held = {.name = 'D', .mask = 3 << FIRST_PIN, .value = (uint8_t)(level << FIRST_PIN)};
	avr_ioctl(b->avr, AVR_IOCTL_IOPORT_SET_EXTERNAL('D'), &held);  // the chip's pull-ups are weaker
	for (int pin = 0; pin < 2; pin++)
		avr_raise_irq(avr_io_getirq(b->avr, AVR_IOCTL_IOPORT_GETIRQ('D'), FIRST_PIN + pin), (level >> pin) & 1);
}

// Return the number of cycles until the next check. The handle cannot reach the next edge in this time.
static avr_cycle_count_t next_check(const struct board *b)
{
	double counts = b->plant.x / b->sensor.metres_per_count + b->sensor.magnet;
	double away = fmin(counts - floor(counts), 1.0 - (counts - floor(counts)));
	double seconds = away * fabs(b->sensor.metres_per_count) / (fabs(b->plant.v) + FASTEST_CHANGE);
	return (avr_cycle_count_t)fmax(SHORTEST, fmin(LONGEST, 0.5 * seconds * FREQUENCY));
}

static avr_cycle_count_t check(avr_t *avr, avr_cycle_count_t when, void *param)
{
	struct board *b = param;
	(void)avr;
	board_sync(b);
	int now = sensor_count(&b->sensor, b->plant.x);
	if (now != b->steps && b->misreading.stuck == 0.0) {
		b->steps += now > b->steps ? 1 : -1;
		drive(b);
		return when + (now == b->steps ? next_check(b) : 16 * SHORTEST);
	}
	return when + next_check(b);
}

void encoder_reset(struct board *b)
{
	b->steps = sensor_count(&b->sensor, b->plant.x);
	drive(b);
	avr_cycle_timer_cancel(b->avr, check, b);
	avr_cycle_timer_register(b->avr, SHORTEST, check, b);
}
