// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "sensor.h"

#include <math.h>
#include <string.h>

static const struct {
	const char *name;
	// usual number of counts after which the reading repeats, and the motor's turns in this time
	double counts, turns;
} KINDS[] = {{"mr", 921, 0.5}, {"as5048a", 16384, 1.0}, {"quadrature", 48, 1.0}};

struct sensor sensor_make(enum sensor_kind kind, double counts, double metres, double magnet, double lowest)
{
	if (counts == 0.0)
		counts = KINDS[kind].counts;
	return (struct sensor){
		.kind = kind, .counts_per_turn = counts, .magnet = magnet,
		.metres_per_count = metres * KINDS[kind].turns / counts,
		.lowest = kind == MAGNETORESISTIVE ? lowest : 0.0,
	};
}

bool sensor_named(const char *name, enum sensor_kind *kind)
{
	for (unsigned i = 0; i < sizeof KINDS / sizeof *KINDS; i++) {
		if (strcmp(name, KINDS[i].name) == 0) {
			*kind = (enum sensor_kind)i;
			return true;
		}
	}
	return false;
}

int sensor_count(const struct sensor *s, double position)
{
	double counts = position / s->metres_per_count + s->magnet;
	if (s->kind == QUADRATURE)
		return (int)floor(counts);
	double turned = counts - s->counts_per_turn * floor(counts / s->counts_per_turn);
	return (int)floor(s->lowest + fmin(turned, s->counts_per_turn - 1e-9));
}

int sensor_millivolts(int count, int reference)
{
	return (count * reference + 1022) / 1023;
}
