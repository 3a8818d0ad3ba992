// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// How board time goes on: with the clock, with the computer's answers, or as fast as it can.
#pragma once

#include "board.h"
#include "script.h"

#include <signal.h>

struct run {
	struct board *board;
	const struct options *options;
	struct script script;
	struct input input;
	unsigned slips;             // stalls after which board time was not made up for
	double slipped;             // s of real time given up in them
	unsigned unanswered;        // answers that did not come in time (lockstep)
};

// Set by a signal handler: end soon.
extern volatile sig_atomic_t run_ended;

// Run until told to quit or until the board time is over.
void run_all(struct run *r);
