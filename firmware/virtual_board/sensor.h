// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The magnetoresistive sensor on the motor shaft, as the converter sees it.
#pragma once

struct sensor {
	double counts_per_turn;  // converter counts per half turn of the motor, after which it repeats
	double metres_per_count; // handle travel per count; negative: the magnet is turned round
	double magnet;           // counts at position 0: the angle at which the magnet happens to sit
	double lowest;           // converter value at the beginning of each half turn
};

// Converter value at a handle position [m]: a saw tooth of whole counts.
int sensor_count(const struct sensor *s, double position);

// Smallest voltage [mV] that a 10-bit converter with this reference [mV] turns into the value.
int sensor_millivolts(int count, int reference);
