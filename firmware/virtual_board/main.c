// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// Usage: virtual_board FIRMWARE.elf [options]; --help lists the options. The program prints `port /dev/pts/N`
// when the port is plugged in, and one JSON object with its counters at the end.

#include "eeprom.h"
#include "run.h"

#include <sched.h>
#include <signal.h>
#include <stdio.h>
#include <stdint.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

static void end(int signal)
{
	(void)signal;
	run_ended = 1;
}

static void catch_signals(void)
{
	struct sigaction action = {.sa_handler = end};
	sigaction(SIGTERM, &action, NULL);
	sigaction(SIGINT, &action, NULL);
	sigaction(SIGHUP, &action, NULL);
	signal(SIGPIPE, SIG_IGN);
}

// At real-time priority, a simulation that is slower than real time would lock the machine. A short time
// slice needs no privilege: Linux 6.12 and later wake the thread sooner for less time; older versions ignore
// it.
static void take_ordinary_priority(void)
{
	struct {
		uint32_t size, policy;
		uint64_t flags;
		int32_t nice;
		uint32_t priority;
		uint64_t runtime, deadline, period;
	} ordinary = {.size = sizeof ordinary, .policy = SCHED_OTHER, .runtime = 100000};
	if (sched_getscheduler(0) == SCHED_OTHER)
		ordinary.nice = getpriority(PRIO_PROCESS, 0);
	const struct sched_param none = {0};
	if (syscall(SYS_sched_setattr, 0, &ordinary, 0) != 0)
		sched_setscheduler(0, SCHED_OTHER, &none);
	prctl(PR_SET_TIMERSLACK, 1UL, 0, 0, 0);
}

static void print_summary(const struct run *r)
{
	const struct board *b = r->board;
	const struct uart *u = &b->uart;
	printf("{\"seconds\": %.9f, \"cycles\": %llu, \"slips\": %u, \"slipped\": %.6f, \"unanswered\": %u, ",
	       board_seconds(b), (unsigned long long)b->avr->cycle, r->slips, r->slipped, r->unanswered);
	printf("\"received\": %llu, \"transmitted\": %llu, \"overruns\": %llu, \"deaf\": %llu, "
	       "\"overwritten\": %llu, ",
	       (unsigned long long)u->received, (unsigned long long)u->transmitted,
	       (unsigned long long)u->overruns, (unsigned long long)u->deaf,
	       (unsigned long long)u->overwritten);
	printf("\"last_byte\": %.9f, ", (double)u->last_received / FREQUENCY);
	printf("\"frames\": %llu, \"dropped\": %llu, \"interrupts_off_cycles\": %llu, "
	       "\"interrupts_off_at\": %u, \"silent_offs\": %u, \"rows\": %llu, \"asleep_cycles\": %llu, ",
	       (unsigned long long)b->link.frames, (unsigned long long)b->link.dropped,
	       (unsigned long long)b->longest_off, b->longest_off_pc, b->silent_offs,
	       (unsigned long long)b->truth.rows, (unsigned long long)b->asleep);
	printf("\"lowest_stack\": %u, ", b->lowest_stack);
	printf("\"ports\": {\"ddrb\": %u, \"portb\": %u, \"ddrd\": %u, \"portd\": %u}, ", b->avr->data[0x24],
	       b->avr->data[0x25], b->avr->data[0x2a], b->avr->data[0x2b]);
	printf("\"spi_frames\": %llu, \"spi_hasty\": %u, \"spi_turned\": %llu, ",
	       (unsigned long long)b->hall.frames, b->spi.hasty + b->spi.overwritten,
	       (unsigned long long)b->hall.turned);
	printf("\"hurt_to\": %llu, \"hurt_from\": %llu, \"lost\": %llu, \"misread\": %llu}\n",
	       (unsigned long long)b->link.to.hurt, (unsigned long long)b->link.from.hurt,
	       (unsigned long long)b->link.lost, (unsigned long long)b->misreading.wrong);
	fflush(stdout);
}

int main(int argc, char **argv)
{
	static struct board board;
	struct options options = options_read(argc, argv);
	struct run run = {.board = &board, .options = &options, .input = {.wanted = options.control}};
	take_ordinary_priority();
	catch_signals();
	script_open(&run.script, options.script);
	board_start(&board, &options);
	script_run(&run.script, &board);  // commands at time 0 apply before the port is announced
	if (board.link.fd < 0)
		link_plug(&board.link);
	run_all(&run);
	link_unplug(&board.link);
	truth_close(&board.truth);
	eeprom_save(board.avr, board.eeprom);
	script_close(&run.script);
	print_summary(&run);
	avr_terminate(board.avr);
	return 0;
}
