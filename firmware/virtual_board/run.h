// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Progress of board time: with the clock, with the computer's answers, or as fast as possible.
#pragma once

#include "board.h"
#include "script.h"

#include <signal.h>

struct run {
	struct board *board;
	const struct options *options;
	struct script script;
	struct input input;
	unsigned slips;             // number of stalls that board time did not catch up
	double slipped;             // s of real time lost in these stalls
	unsigned unanswered;        // answers that were late (lockstep)
};

// Set by a signal handler: end soon.
extern volatile sig_atomic_t run_ended;

// Run until a command to quit, or to the end of the board time.
void run_all(struct run *r);
