// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
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
	int fd;                    // -1 while the cable is unplugged
	char path[64];
	const char *alias;         // a symbolic link to the port, or NULL
	bool open;                 // the computer has the port open
	bool opened;               // the computer has had the port open at least once
	bool rang;                 // the port has been opened since this was last cleared
	uint8_t in[LINK_IN];       // bytes from the computer that are not on the line yet
	size_t in_at, in_end;
	size_t admitted;           // end of the bytes that may go onto the line
	uint8_t out[LINK_OUT];     // bytes on the way to the computer
	size_t out_end;
	uint8_t frame_head[2];     // first bytes of the frame that is being sent
	size_t frame_length;
	int awaited;               // identifier of the frames that need an answer
	bool asked;                // such a frame has been sent since this was last cleared
	uint64_t frames, dropped;  // number of frames sent; number of bytes that were not read
	uint64_t fetched, handed;  // number of bytes from and to the computer since the cable was plugged in

	const avr_cycle_count_t *clock;
	avr_cycle_count_t latency;             // latency timer of the USB chip; 0 passes frames on at once
	avr_cycle_count_t packet_due;          // end of the latency timer
	avr_cycle_count_t to_held, from_held;  // end of a stall in each direction; 0 without a stall
	avr_cycle_count_t due;                 // the earliest of these times, at which link_tick must be called
	struct damage to, from;
	uint8_t next[2];                       // bytes for the board after fault injection
	int next_at, next_end;
	// number of bytes for which the chip's buffer was full during a stall
	uint64_t lost;
};

// Plug in: create a pseudo-terminal and print its name. Exit with a message on failure.
void link_plug(struct link *l);

// Unplug the cable; the computer gets a hang-up.
void link_unplug(struct link *l);

// Read received bytes; check whether the computer has the port open.
void link_fetch(struct link *l);

// Put all received bytes on the line.
void link_admit(struct link *l);

// Put complete frames on the line, one or all; return false if there is no complete frame.
bool link_admit_frames(struct link *l, bool all);

// Remove a lone delimiter, by which the computer reports that it sends nothing; return false without such a
// delimiter. The firmware does not receive it, because a real line would be idle.
bool link_take_silence(struct link *l);

// For the chip's serial port: take a byte from the computer, or pass a byte to it.
int link_next(void *link);
void link_sent(void *link, uint8_t byte);

// Pass the bytes sent so far to the computer, unless a USB chip holds them back.
void link_flush(struct link *l);

// Set the latency timer of the USB chip; 0 means none.
void link_set_latency(struct link *l, avr_cycle_count_t latency);

// Pass no bytes to or from the board for some cycles. Bytes beyond the chip's buffer are lost.
void link_stall(struct link *l, bool to, avr_cycle_count_t cycles);

// End the stall or the latency timer that is due.
void link_tick(struct link *l);
