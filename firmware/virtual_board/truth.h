// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The truth log, which contains the true state at every conversion of the sensor or at a fixed period.
#pragma once

#include <stdint.h>
#include <stdio.h>

enum { TRUTH_COLUMNS = 8 };

struct truth {
	FILE *file;     // NULL without a log
	uint64_t rows;
};

// A row contains TRUTH_COLUMNS little-endian float64: board time [s], position [m], velocity [m/s], motor
// force [N], duty (-255 to 255), hand force [N], hand target [m], converter value.
void truth_open(struct truth *t, const char *path);
void truth_write(struct truth *t, const double row[TRUTH_COLUMNS]);
void truth_flush(struct truth *t);
void truth_close(struct truth *t);
