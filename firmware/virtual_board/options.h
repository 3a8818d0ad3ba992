// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Command line.
#pragma once

#include "faults.h"
#include "sensor.h"

#include <stdbool.h>

enum mode { PACED, LOCKSTEP, TURNS, FAST };

struct options {
	const char *firmware, *bootloader, *link, *log, *script, *eeprom;
	enum mode mode;
	bool control;             // commands on standard input
	double seconds;           // board time to run; infinite by default
	double slice;             // s of board time between two looks at the clock and at the cable
	double answer_timeout;    // s of real time that lockstep waits for an answer
	double awaited;           // identifier of the frames that the computer answers, in lockstep
	double log_period;        // s; 0: a row per conversion of the sensor

	double mass, viscous, coulomb, stop;                   // paddle
	double position, velocity;                             // at the start
	double handle_radius, pulley_radius, sector_radius;    // m
	double torque, direction;                              // N m at full duty; sign while the pin is high
	double pins, motor_power, dead_band;
	enum sensor_kind sensor;
	double sensor_absent, spi_flip;
	double counts, lowest, magnet, sensor_sign;

	struct damage to, from;                                // what goes wrong
	struct misreading misreading;
	double latency, seed;
};

// Read the command line; on a mistake print what is wrong and exit with code 2.
struct options options_read(int argc, char **argv);
