// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "sensor.h"

#include <math.h>

int sensor_count(const struct sensor *s, double position)
{
	double counts = position / s->metres_per_count + s->magnet;
	double turned = counts - s->counts_per_turn * floor(counts / s->counts_per_turn);
	return (int)floor(s->lowest + fmin(turned, s->counts_per_turn - 1e-9));
}

int sensor_millivolts(int count, int reference)
{
	return (count * reference + 1022) / 1023;
}
