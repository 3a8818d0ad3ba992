// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// What goes wrong on purpose: bytes on the cable, readings of the sensor. The same seed, the same faults.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// One direction of the cable. Rates are probabilities per byte; single shots count down.
struct damage {
	double drop, flip, insert;     // lost; one bit turned; a random byte put before it
	double burst, length;          // a burst begins; so many bytes are replaced by random ones
	double lose, garble, add;      // single shots: the next bytes that are lost, replaced, preceded by another
	double bursting;               // bytes of the present burst still to come
	uint64_t random;
	uint64_t hurt;                 // bytes damaged so far
};

// Pass one byte; return how many come out of the other end, 0 to 2.
int damage_pass(struct damage *d, uint8_t byte, uint8_t out[2]);

// The sensor's readings, in counts.
struct misreading {
	double stuck;                  // 1: repeats the last good reading
	double noise;                  // standard deviation added [counts]
	double jump;                   // probability that a reading is half a turn off or outside the range
	uint64_t random;
	uint64_t wrong;                // readings changed so far
	int last;                      // last good one
};

// Return what the converter reads in place of a count between lowest and lowest + range.
int misread(struct misreading *m, int count, int lowest, int range);

// Start the three sources of chance, all of them from one seed.
void faults_seed(struct damage *to, struct damage *from, struct misreading *sensor, double seed);
