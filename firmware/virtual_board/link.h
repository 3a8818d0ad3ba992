// Virtual board: the Hapkit firmware in simavr with the paddle around it.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The serial cable: a pseudo-terminal whose other end the computer opens.
#pragma once

#include "faults.h"

#include <sim_avr_types.h>
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { LINK_IN = 4096, LINK_OUT = 512 };

struct link {
	int fd;                    // -1: unplugged
	char path[64];
	const char *alias;         // symbolic link kept on the port, or NULL
	bool open;                 // the computer has the port open
	bool opened;               // it had, at least once
	bool rang;                 // it has been opened since this was last cleared
	uint8_t in[LINK_IN];       // from the computer, not yet on the line
	size_t in_at, in_end;
	size_t admitted;           // end of what may go onto the line
	uint8_t out[LINK_OUT];     // on its way to the computer
	size_t out_end;
	uint8_t frame_head[2];     // of the frame that is being sent
	size_t frame_length;
	int awaited;               // identifier of the frames that the computer answers
	bool asked;                // such a frame has gone out since this was last cleared
	uint64_t frames, dropped;  // frames out; bytes that nobody read
	uint64_t fetched, handed;  // bytes from and to the computer since the plug

	const avr_cycle_count_t *clock;
	avr_cycle_count_t latency;             // of the USB chip, 0: a frame goes to the computer at once
	avr_cycle_count_t packet_due;          // end of its latency timer
	avr_cycle_count_t to_held, from_held;  // nothing comes through until then, 0: everything does
	avr_cycle_count_t due;                 // the first of these: when link_tick has to be called
	struct damage to, from;
	uint8_t next[2];                       // bytes for the board behind the damage
	int next_at, next_end;
	uint64_t lost;                         // bytes for which the chip had no room while it could not hand over
};

// Plug in: make a pseudo-terminal, print its name. Exits the program with a message if there is none.
void link_plug(struct link *l);

// Pull the cable: the computer sees a hang-up.
void link_unplug(struct link *l);

// Read what the computer has sent; notice whether it has the port open.
void link_fetch(struct link *l);

// Let everything onto the line that has come.
void link_admit(struct link *l);

// Let whole frames onto the line, one or all that are there; false if there is none.
bool link_admit_frames(struct link *l, bool all);

// Take a lone delimiter away, by which the computer says that it has nothing to say; false if there is none. The
// firmware does not get it: on a real line there would be nothing at all.
bool link_take_silence(struct link *l);

// For the chip's serial port: take a byte out, put one in.
int link_next(void *link);
void link_sent(void *link, uint8_t byte);

// Hand what has been sent so far to the computer, where no USB chip holds it back.
void link_flush(struct link *l);

// Set the latency timer of the USB chip, 0: none.
void link_set_latency(struct link *l, avr_cycle_count_t latency);

// Let nothing through for so long, to the board or from it. What the chip has no room for is lost.
void link_stall(struct link *l, bool to, avr_cycle_count_t cycles);

// Note that a stall or the latency timer has ended.
void link_tick(struct link *l);
