// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The progress of board time: with the clock, with the computer's answers, or as fast as possible.
#pragma once

#include "board.h"
#include "script.h"

#include <signal.h>

struct run {
	struct board *board;
	const struct options *options;
	struct script script;
	struct input input;
	unsigned slips;             // number of delays that board time did not make up for
	double slipped;             // real time [s] lost in these delays
	unsigned unanswered;        // in lockstep, number of answers that were late
};

// A signal handler sets this to end the run soon.
extern volatile sig_atomic_t run_ended;

// Run until a command to quit, or until the end of the board time.
void run_all(struct run *r);
