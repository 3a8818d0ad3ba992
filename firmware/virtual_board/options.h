// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The command line.
#pragma once

#include "faults.h"
#include "sensor.h"

#include <stdbool.h>

enum mode { PACED, LOCKSTEP, TURNS, FAST };

struct options {
	const char *firmware, *bootloader, *link, *log, *script, *eeprom;
	enum mode mode;
	bool control;             // commands come on standard input
	double seconds;           // board time to run [s]; infinite by default
	double slice;             // board time [s] between two checks of the clock and the cable
	double answer_timeout;    // real time [s] for which lockstep waits for an answer
	double awaited;           // in lockstep, identifier of the frames that need an answer
	double log_period;        // [s]; 0 writes a row per conversion of the sensor

	double mass, viscous, coulomb, stop;                   // properties of the paddle
	double position, velocity;                             // initial values
	double handle_radius, pulley_radius, sector_radius;    // m
	// N m at full duty; sign of the force while the direction pin is high
	double torque, direction;
	double pins, motor_power, dead_band;
	enum sensor_kind sensor;
	double sensor_absent, spi_flip;
	double counts, lowest, magnet, sensor_sign;

	struct damage to, from;                                // injected faults
	struct misreading misreading;
	double latency, seed;
};

// Parse the command line; after an error print the error and exit with code 2.
struct options options_read(int argc, char **argv);
