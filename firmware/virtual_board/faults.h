// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Injected faults: bytes on the cable, and readings of the sensor. A seed makes them reproducible.
#pragma once

#include <stdbool.h>
#include <stdint.h>

// One direction of the cable. Rates are probabilities per byte; counts for single faults count down.
struct damage {
	double drop, flip, insert;     // a byte is lost; a bit is inverted; a random byte is inserted before it
	double burst, length;          // a burst starts; number of bytes that it replaces by random ones
	// single faults: number of bytes to lose, to replace, and to precede by a random byte
	double lose, garble, add;
	double bursting;               // remaining bytes of the present burst
	uint64_t random;
	uint64_t hurt;                 // number of damaged bytes
};

// Pass one byte; return the number of bytes that come out, 0 to 2.
int damage_pass(struct damage *d, uint8_t byte, uint8_t out[2]);

// The faults of the sensor's readings, in counts.
struct misreading {
	double stuck;                  // 1 repeats the last good reading
	double noise;                  // standard deviation of added noise [counts]
	double jump;                   // probability that a reading is half a turn off or outside the range
	uint64_t random;
	uint64_t wrong;                // number of changed readings
	int last;                      // last good reading
};

// Return the converter's value for a count from lowest to lowest + range.
int misread(struct misreading *m, int count, int lowest, int range);

// Initialise all three random generators from one seed.
void faults_seed(struct damage *to, struct damage *from, struct misreading *sensor, double seed);
