// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "command.h"

#include "fault_command.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { MAX_NUMBERS = 7 };

struct call {
	struct board *board;
	double number[MAX_NUMBERS];
	int count;
};

static void hand(struct call *c)
{
	struct plant *p = &c->board->plant;
	bool takes = !p->held || p->prescribed;
	if (takes)
		plant_aim(p, p->x, 0.0);
	p->prescribed = false;
	p->held = true;
	p->hand_stiffness = c->number[1];
	p->hand_damping = c->number[2];
	p->hand_mass = c->number[3];
	double seconds = c->number[4];
	p->arriving = takes || (p->arriving && p->ramp > seconds);
	double most = c->number[p->arriving ? 5 : 6];
	double least = most > 0.0 ? fabs(c->number[0] - p->target) / most : 0.0;
	plant_aim(p, c->number[0], fmax(seconds, least));
}

static void release(struct call *c)
{
	c->board->plant.held = c->board->plant.prescribed = false;
}

static void force(struct call *c)
{
	c->board->plant.external = c->number[0];
}

static void position(struct call *c)
{
	struct plant *p = &c->board->plant;
	p->held = false;
	if (!p->prescribed)
		plant_aim(p, p->x, 0.0);
	p->prescribed = true;
	plant_aim(p, c->number[0], c->number[1]);
	if (p->ramp == 0.0)
		p->x = p->target;
	p->v = 0.0;
}

static void plug(struct call *c)
{
	if (c->board->link.fd < 0)
		link_plug(&c->board->link);
}

static void unplug(struct call *c)
{
	link_unplug(&c->board->link);
}

static void reset(struct call *c)
{
	board_reset(c->board);
}

static void freeze(struct call *c)
{
	c->board->frozen = true;
}

static void resume(struct call *c)
{
	c->board->frozen = false;
}

static void flush(struct call *c)
{
	truth_flush(&c->board->truth);
	printf("flushed %llu\n", (unsigned long long)c->board->truth.rows);
	fflush(stdout);
}

static void status(struct call *c)
{
	const struct board *b = c->board;
	printf("status {\"time\": %.9f, \"position\": %.17g, \"velocity\": %.17g, \"motor_force\": %.17g, "
	       "\"duty\": %d, \"hand_force\": %.17g, \"open\": %s, \"asleep_cycles\": %llu}\n",
	       board_seconds(b), b->plant.x, b->plant.v, b->plant.motor, b->motor.duty,
	       plant_hand_force(&b->plant), b->link.open ? "true" : "false",
	       (unsigned long long)b->asleep);
	fflush(stdout);
}

static void go(struct call *c)
{
	c->board->announced = c->number[0];
}

static void quit(struct call *c)
{
	c->board->quit = true;
}

static const struct {
	const char *name;
	int least, most;  // smallest and largest number of arguments
	void (*run)(struct call *);
} COMMANDS[] = {
	{"hand", 4, 7, hand},     {"release", 0, 0, release}, {"force", 1, 1, force},
	{"position", 1, 2, position}, {"plug", 0, 0, plug},   {"unplug", 0, 0, unplug},
	{"reset", 0, 0, reset},   {"freeze", 0, 0, freeze},   {"resume", 0, 0, resume},
	{"flush", 0, 0, flush},   {"status", 0, 0, status},   {"quit", 0, 0, quit},
	{"go", 1, 1, go},
};

// Parse the numbers of a line; return -1 if a word is not a finite number or there are too many.
static int read_numbers(const char *text, double *number)
{
	int count = 0;
	for (;;) {
		text += strspn(text, " \t\r\n");
		if (!*text)
			return count;
		char *end;
		double value = strtod(text, &end);
		if (end == text || !strchr(" \t\r\n", *end) || !isfinite(value) || count == MAX_NUMBERS)
			return -1;
		number[count++] = value;
		text = end;
	}
}

bool command_run(struct board *b, const char *line)
{
	line += strspn(line, " \t\r\n");
	size_t length = strcspn(line, " \t\r\n");
	if (length == 0 || *line == '#')
		return true;
	for (size_t i = 0; i < sizeof COMMANDS / sizeof *COMMANDS; i++) {
		if (strlen(COMMANDS[i].name) != length || strncmp(line, COMMANDS[i].name, length) != 0)
			continue;
		struct call c = {.board = b};
		c.count = read_numbers(line + length, c.number);
		if (c.count < COMMANDS[i].least || c.count > COMMANDS[i].most)
			break;
		board_sync(b);
		COMMANDS[i].run(&c);
		return true;
	}
	if (fault_command(b, line))
		return true;
	fprintf(stderr, "virtual_board: not understood: %.*s\n", (int)strcspn(line, "\r\n"), line);
	return false;
}
