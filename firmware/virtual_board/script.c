// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "script.h"
#include "command.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static void fail(const char *what, const char *why)
{
	fprintf(stderr, "virtual_board: script: %s: %s\n", what, why);
	exit(2);
}

// Advance to the next line with a command; s->line then points to the text after its time.
static void next_line(struct script *s, char *from)
{
	s->line = NULL;
	avr_cycle_count_t before = s->due;
	s->due = (avr_cycle_count_t)-1;
	while (from && *from) {
		char *end = strchr(from, '\n');
		char *text = from + strspn(from, " \t\r");
		if (*text && *text != '\n' && *text != '#') {
			char *rest;
			double seconds = strtod(text, &rest);
			if (rest == text || !(seconds >= 0.0 && seconds < 1e9))
				fail(text, "a line begins with its time in seconds");
			s->due = (avr_cycle_count_t)llround(seconds * FREQUENCY);
			if (s->due < before)
				fail(text, "the times have to increase");
			s->line = rest;
			return;
		}
		from = end ? end + 1 : NULL;
	}
}

void script_open(struct script *s, const char *path)
{
	*s = (struct script){.due = (avr_cycle_count_t)-1};
	if (!path)
		return;
	FILE *file = fopen(path, "rb");
	size_t size = 0;
	ssize_t length = file ? getdelim(&s->text, &size, 0, file) : -1;
	if (!file || (length < 0 && !feof(file)))
		fail(path, strerror(errno));
	fclose(file);
	s->due = 0;
	next_line(s, length < 0 ? NULL : s->text);
}

void script_close(struct script *s)
{
	free(s->text);
}

void script_run(struct script *s, struct board *b)
{
	while (s->line && s->due <= b->avr->cycle) {
		char *end = strchr(s->line, '\n');
		if (end)
			*end = 0;
		if (!command_run(b, s->line))
			exit(2);
		next_line(s, end ? end + 1 : NULL);
	}
}

static void take_lines(struct input *in, struct board *b)
{
	char *from = in->text;
	for (char *end; (end = memchr(from, '\n', in->length)) != NULL; from = end + 1) {
		*end = 0;
		command_run(b, from);
		in->length -= (size_t)(end + 1 - from);
	}
	memmove(in->text, from, in->length);
	if (in->length == sizeof in->text)
		in->length = 0;  // discard a line that is longer than any command
}

void input_run(struct input *in, struct board *b)
{
	struct pollfd p = {.fd = STDIN_FILENO, .events = POLLIN};
	if (!in->wanted || poll(&p, 1, 0) <= 0)
		return;
	ssize_t n = read(STDIN_FILENO, in->text + in->length, sizeof in->text - in->length);
	if (n == 0 || (n < 0 && errno != EINTR && errno != EAGAIN))
		b->quit = true;
	if (n <= 0)
		return;
	in->length += (size_t)n;
	take_lines(in, b);
}
