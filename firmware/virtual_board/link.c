// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "link.h"

#include <errno.h>
#include <fcntl.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <termios.h>
#include <unistd.h>

static void fail(const char *what)
{
	fprintf(stderr, "virtual_board: %s: %s\n", what, strerror(errno));
	exit(1);
}

// Set raw mode: no echo, line ends or signals, independent of earlier settings.
static void make_raw(int fd)
{
	struct termios t;
	if (tcgetattr(fd, &t) != 0)
		fail("terminal settings");
	cfmakeraw(&t);
	if (tcsetattr(fd, TCSANOW, &t) != 0)
		fail("terminal settings");
}

static void keep_alias(const struct link *l)
{
	if (!l->alias)
		return;
	unlink(l->alias);
	if (symlink(l->path, l->alias) != 0)
		fail(l->alias);
}

void link_plug(struct link *l)
{
	l->fd = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
	if (l->fd < 0 || grantpt(l->fd) != 0 || unlockpt(l->fd) != 0 ||
	    ptsname_r(l->fd, l->path, sizeof l->path) != 0)
		fail("no pseudo-terminal");
	int slave = open(l->path, O_RDWR | O_NOCTTY | O_CLOEXEC);
	if (slave < 0)
		fail(l->path);
	make_raw(slave);
	close(slave);  // after this, a hang-up means that no program has the port open
	l->open = l->opened = l->rang = l->asked = false;
	l->in_at = l->in_end = l->admitted = l->out_end = 0;
	l->fetched = l->handed = 0;
	keep_alias(l);
	printf("port %s\n", l->path);
	fflush(stdout);
}

void link_unplug(struct link *l)
{
	if (l->fd < 0)
		return;
	close(l->fd);
	l->fd = -1;
	l->open = false;
	l->in_at = l->in_end = l->admitted = l->out_end = 0;
	if (l->alias)
		unlink(l->alias);
}

static void make_room(struct link *l)
{
	memmove(l->in, l->in + l->in_at, l->in_end - l->in_at);
	l->in_end -= l->in_at;
	l->admitted -= l->in_at;
	l->in_at = 0;
}

void link_fetch(struct link *l)
{
	if (l->fd < 0)
		return;
	struct pollfd p = {.fd = l->fd, .events = POLLIN};
	if (poll(&p, 1, 0) < 0)
		return;
	bool before = l->open;
	l->open = !(p.revents & POLLHUP);
	l->rang |= l->open && !before;
	l->opened |= l->open;
	if (!(p.revents & POLLIN))
		return;
	make_room(l);
	ssize_t n = read(l->fd, l->in + l->in_end, LINK_IN - l->in_end);
	if (n > 0) {
		l->in_end += (size_t)n;
		l->fetched += (size_t)n;
	}
}

void link_admit(struct link *l)
{
	l->admitted = l->in_end;
}

bool link_admit_frames(struct link *l, bool all)
{
	size_t start = l->admitted;
	for (size_t i = start; i < l->in_end; i++) {
		if (l->in[i] != 0)
			continue;
		bool empty = i == start;  // a lone delimiter, which ends a partial frame
		start = i + 1;
		if (empty)
			continue;
		l->admitted = start;
		if (!all)
			break;
	}
	if (l->in_end == LINK_IN && l->in_at == 0)
		l->admitted = l->in_end;  // this is longer than any frame, so pass it to the firmware
	return l->admitted > l->in_at;
}

bool link_take_silence(struct link *l)
{
	if (l->admitted == l->in_end || l->in[l->admitted] != 0)
		return false;
	l->in_end--;
	memmove(l->in + l->admitted, l->in + l->admitted + 1, l->in_end - l->admitted);
	return true;
}
