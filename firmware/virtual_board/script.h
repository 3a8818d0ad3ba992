// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Sources of commands: a script, whose lines are executed at given times of the board, and standard input.
#pragma once

#include "board.h"

struct script {
	char *text;                     // whole file
	char *line;                     // next line; NULL after the last line
	avr_cycle_count_t due;          // cycle of the next line; the largest value after the last line
};

// Read a script of lines `seconds command` with non-decreasing times. Exit with a message if the script is
// invalid.
void script_open(struct script *s, const char *path);
void script_close(struct script *s);

// Execute the commands that are due.
void script_run(struct script *s, struct board *b);

struct input {
	bool wanted;
	char text[1024];
	size_t length;
};

// Read standard input without waiting; the end of the input quits the board.
void input_run(struct input *in, struct board *b);
