// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Where commands come from: a script by board time, lines on standard input.
#pragma once

#include "board.h"

struct script {
	char *text;                     // whole file
	char *line;                     // next line, NULL: none
	avr_cycle_count_t due;          // its cycle; the largest there is: none
};

// Read a script of lines `seconds command`, times not decreasing. Exits with a message if it is not one.
void script_open(struct script *s, const char *path);
void script_close(struct script *s);

// Carry out what is due.
void script_run(struct script *s, struct board *b);

struct input {
	bool wanted;
	char text[1024];
	size_t length;
};

// Read standard input without waiting; its end asks the board to quit.
void input_run(struct input *in, struct board *b);
