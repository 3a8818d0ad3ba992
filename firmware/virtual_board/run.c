// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

#include "run.h"

#include <errno.h>
#include <math.h>
#include <poll.h>
#include <time.h>
#include <unistd.h>

// Longest board time [s] before the board waits for the computer, if no frame needs an answer earlier. It is
// shorter than the 25 ms after which the firmware switches the motor off.
#define IDLE_GRANT 20e-3
// Time [s] between checks for events that cause no notification (port opened, port closed, end of a freeze).
#define POLL_PERIOD 5e-3

volatile sig_atomic_t run_ended;

static double clock_now(void)
{
	struct timespec t;
	clock_gettime(CLOCK_MONOTONIC, &t);
	return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static bool over(const struct run *r)
{
	return run_ended || r->board->quit || board_seconds(r->board) >= r->options->seconds;
}

// Sleep until the computer or a command sends data, or for a time. A port that is hung up is excluded,
// because poll would always return at once.
static void wait_for_events(struct run *r, double seconds)
{
	struct board *b = r->board;
	bool room = b->link.in_end - b->link.in_at < LINK_IN;
	struct pollfd p[2] = {
		{.fd = b->link.open && room ? b->link.fd : -1, .events = POLLIN},
		{.fd = r->input.wanted ? STDIN_FILENO : -1, .events = POLLIN},
	};
	seconds = fmax(seconds, 0.0);
	struct timespec t = {(time_t)seconds, (long)(1e9 * (seconds - floor(seconds)))};
	if (ppoll(p, 2, &t, NULL) <= 0)
		return;
	if (p[0].revents)
		link_fetch(&b->link);
	if (p[1].revents)
		input_run(&r->input, b);
}

static avr_cycle_count_t cycles(double seconds)
{
	return (avr_cycle_count_t)llround(seconds * FREQUENCY);
}

static void run_board(struct run *r, avr_cycle_count_t end, bool stop_at_frame)
{
	struct board *b = r->board;
	if (r->options->seconds * FREQUENCY < (double)end)
		end = cycles(r->options->seconds);
	for (;;) {
		script_run(&r->script, b);
		if (b->avr->cycle >= end || b->quit || b->frozen || (stop_at_frame && b->link.asked))
			break;
		board_run(b, r->script.due < end ? r->script.due : end, stop_at_frame);
	}
	link_flush(&b->link);
}

static void sleep_until(struct run *r, double deadline)
{
	for (double left; (left = deadline - clock_now()) > 0.0 && !over(r);)
		wait_for_events(r, left);
}

// Stop the board until a command resumes it.
static void stay_frozen(struct run *r)
{
	while (r->board->frozen && !over(r))
		wait_for_events(r, POLL_PERIOD);
}

static void run_paced(struct run *r)
{
	const double slice = r->options->slice;
	double deadline = clock_now(), next_poll = deadline;
	avr_cycle_count_t end = r->board->avr->cycle;
	while (!over(r)) {
		sleep_until(r, deadline);
		double now = clock_now(), late = now - deadline;
		if (late > slice) {
			r->slips++;
			r->slipped += late;
			deadline = now;
		}
		if (late > 0.5 * slice || now > next_poll) {
			link_fetch(&r->board->link);  // otherwise sleep_until has done this already
			next_poll = now + POLL_PERIOD;
		}
		link_admit(&r->board->link);
		end += cycles(slice);
		run_board(r, end, false);
		deadline += slice;
		if (r->board->frozen) {
			stay_frozen(r);
			deadline = clock_now();
			end = r->board->avr->cycle;
		}
	}
}

static bool answered(struct link *l)
{
	return link_admit_frames(l, l->asked) || (l->asked && link_take_silence(l));
}

// Wait for a complete frame from the computer, or for a lone delimiter; there is no time limit if no answer
// was requested. Without a request, frames are admitted one at a time, so that the result does not depend on
// the time at which frames arrive.
static void wait_for_answer(struct run *r)
{
	struct link *l = &r->board->link;
	double deadline = clock_now() + (l->asked ? r->options->answer_timeout : INFINITY);
	while (!over(r) && !answered(l)) {
		if (clock_now() > deadline) {
			r->unanswered++;
			return;
		}
		wait_for_events(r, POLL_PERIOD);
		link_fetch(l);
		if (l->opened && !l->open)
			return;
	}
}

static void run_lockstep(struct run *r)
{
	struct link *l = &r->board->link;
	while (!over(r)) {
		l->asked = false;
		double start = clock_now();
		bool alone = l->opened && !l->open;
		double grant = alone ? r->options->slice : IDLE_GRANT;
		run_board(r, r->board->avr->cycle + cycles(grant), true);
		stay_frozen(r);
		if (alone) {
			sleep_until(r, start + r->options->slice);
			link_fetch(l);
		} else {
			wait_for_answer(r);
		}
	}
}

static bool more_to_come(const struct link *l, double announced)
{
	return l->fd >= 0 && l->in_end - l->in_at < LINK_IN && (double)l->fetched < announced;
}

// Tell the computer the board time and the number of bytes to read; then wait until the computer reports the
// number of bytes that it has sent, and until these bytes have arrived. Bytes need time to pass a
// pseudo-terminal. Both sides count the bytes, so the result does not depend on this time.
static void wait_for_turn(struct run *r)
{
	struct board *b = r->board;
	b->announced = -1.0;
	printf("turn %.9f %llu\n", board_seconds(b), (unsigned long long)b->link.handed);
	fflush(stdout);
	while (!over(r) && (b->announced < 0.0 || more_to_come(&b->link, b->announced))) {
		wait_for_events(r, POLL_PERIOD);
		link_fetch(&b->link);  // a port that was just opened is not polled yet
	}
	link_admit(&b->link);
}

static void run_turns(struct run *r)
{
	while (!over(r)) {
		r->board->link.asked = false;
		link_fetch(&r->board->link);
		run_board(r, r->board->avr->cycle + cycles(IDLE_GRANT), true);
		if (!over(r))
			wait_for_turn(r);
	}
}

static void run_fast(struct run *r)
{
	while (!over(r)) {
		stay_frozen(r);
		link_fetch(&r->board->link);
		link_admit(&r->board->link);
		input_run(&r->input, r->board);
		run_board(r, r->board->avr->cycle + cycles(1e-3), false);
	}
}

void run_all(struct run *r)
{
	if (r->options->mode == PACED)
		run_paced(r);
	else if (r->options->mode == LOCKSTEP)
		run_lockstep(r);
	else if (r->options->mode == TURNS)
		run_turns(r);
	else
		run_fast(r);
}
