// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The angle sensor on the motor shaft.
#pragma once

#include <stdbool.h>

enum sensor_kind { MAGNETORESISTIVE, AS5048A, QUADRATURE };

struct sensor {
	enum sensor_kind kind;
	double counts_per_turn;  // counts after which the reading repeats; for a quadrature encoder, counts per turn
	double metres_per_count; // handle travel per count; it is negative if the magnet is reversed
	double magnet;           // counts at position 0, given by the mounting angle of the magnet
	double lowest;           // converter value at the beginning of each half turn
};

// Create a sensor. counts is the number after which the reading repeats; 0 selects the usual number.
// metres is the handle travel per turn of the motor; it is negative if the magnet is reversed.
struct sensor sensor_make(enum sensor_kind kind, double counts, double metres, double magnet, double lowest);

// Find a kind by its name; return false if there is no such kind.
bool sensor_named(const char *name, enum sensor_kind *kind);

// Return the reading at a handle position [m]: a saw tooth of whole counts, or the count itself for an
// encoder.
int sensor_count(const struct sensor *s, double position);

// Return the smallest voltage [mV] that a 10-bit converter with this reference [mV] converts to the value.
int sensor_millivolts(int count, int reference);
