// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "fault_command.h"

#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

struct setting {
	const char *name;
	size_t offset;
	double high;
};

#define DAMAGE(field, high) {#field, offsetof(struct damage, field), high}
#define SENSOR(field, high) {#field, offsetof(struct misreading, field), high}

static const struct setting CABLE[] = {
	DAMAGE(drop, 1), DAMAGE(flip, 1), DAMAGE(insert, 1), DAMAGE(burst, 1),
	DAMAGE(lose, 1e9), DAMAGE(garble, 1e9), DAMAGE(add, 1e9), {NULL, 0, 0},
};
static const struct setting READING[] = {
	SENSOR(stuck, 1), SENSOR(noise, 1000), SENSOR(jump, 1), {NULL, 0, 0},
};

static bool set(void *where, const struct setting *table, const char *name, double value)
{
	for (; table->name; table++) {
		if (strcmp(name, table->name) != 0 || !(value >= 0.0 && value <= table->high))
			continue;
		*(double *)((char *)where + table->offset) = value;
		return true;
	}
	return false;
}

static bool cable(struct board *b, bool to, const char *name, double value, double length)
{
	struct damage *d = to ? &b->link.to : &b->link.from;
	if (strcmp(name, "stall") == 0 && value > 0.0 && value < 1e6) {
		link_stall(&b->link, to, (avr_cycle_count_t)llround(value * FREQUENCY));
		return true;
	}
	if (length >= 1.0)
		d->length = length;
	return set(d, CABLE, name, value);
}

bool fault_command(struct board *b, const char *line)
{
	char where[8], what[8], rest[2];
	double value, length = 0.0;
	int words = sscanf(line, "%7s %7s %lf %lf %1s", where, what, &value, &length, rest);
	if (words < 3 || words > 4 || (words == 4 && strcmp(what, "burst") != 0))
		return false;
	if (strcmp(where, "sensor") == 0)
		return set(&b->misreading, READING, what, value);
	if (strcmp(where, "usb") == 0 && strcmp(what, "latency") == 0 && value >= 0.0 && value <= 1.0) {
		link_set_latency(&b->link, (avr_cycle_count_t)llround(value * FREQUENCY));
		return true;
	}
	return (strcmp(where, "to") == 0 || strcmp(where, "from") == 0) &&
	       cable(b, where[0] == 't', what, value, length);
}
