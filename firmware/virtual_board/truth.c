// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "truth.h"

#include <errno.h>
#include <stdlib.h>
#include <string.h>

#if __BYTE_ORDER__ != __ORDER_LITTLE_ENDIAN__
#error "the log is written as it stands in memory: little-endian machines only"
#endif

static void fail(const char *what)
{
	fprintf(stderr, "virtual_board: truth log: %s: %s\n", what, strerror(errno));
	exit(1);
}

void truth_open(struct truth *t, const char *path)
{
	if (!path)
		return;
	t->file = fopen(path, "wb");
	if (!t->file || setvbuf(t->file, NULL, _IOFBF, 1 << 18) != 0)
		fail(path);
}

void truth_write(struct truth *t, const double row[TRUTH_COLUMNS])
{
	if (!t->file)
		return;
	if (fwrite(row, sizeof *row, TRUTH_COLUMNS, t->file) != TRUTH_COLUMNS)
		fail("disk full?");
	t->rows++;
}

void truth_flush(struct truth *t)
{
	if (t->file && fflush(t->file) != 0)
		fail("disk full?");
}

void truth_close(struct truth *t)
{
	if (t->file && fclose(t->file) != 0)
		fail("disk full?");
	t->file = NULL;
}
