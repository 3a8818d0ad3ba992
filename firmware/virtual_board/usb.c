// Virtual board: the Hapkit firmware in the simulator simavr, connected to a simulated paddle.
// Copyright (C) 2026 the Hapkit Studio developers
// SPDX-License-Identifier: GPL-3.0-or-later

// The USB chip between serial line and computer, as in FTDI's note AN232B-04. Bytes from the board are passed
// to the computer when a packet of 62 bytes is full or when the latency timer ends; the timer restarts with
// each packet.

#include "link.h"

#include <string.h>
#include <unistd.h>

enum { PACKET = 62 };

static bool passed(avr_cycle_count_t when, avr_cycle_count_t now)
{
	return when != 0 && now >= when;
}

static void plan(struct link *l)
{
	const avr_cycle_count_t times[] = {l->packet_due, l->to_held, l->from_held};
	l->due = (avr_cycle_count_t)-1;
	for (int i = 0; i < 3; i++)
		if (times[i] && times[i] < l->due)
			l->due = times[i];
}

// --- to the board
int link_next(void *link)
{
	struct link *l = link;
	if (l->to_held)
		return -1;
	while (l->next_at == l->next_end) {
		if (l->in_at == l->admitted)
			return -1;
		l->next_at = 0;
		l->next_end = damage_pass(&l->to, l->in[l->in_at++], l->next);
	}
	return l->next[l->next_at++];
}

// --- to the computer
// A frame's identifier is its first byte after the COBS code; a COBS code of 1 stands for an identifier of 0.
static int identifier(const struct link *l)
{
	if (l->frame_length < 3)
		return -1;
	return l->frame_head[0] == 1 ? 0 : l->frame_head[1];
}

static void note(struct link *l, uint8_t byte)
{
	if (l->frame_length < 2)
		l->frame_head[l->frame_length] = byte;
	l->frame_length++;
	if (byte != 0)
		return;
	l->asked |= l->awaited == 0 || identifier(l) == l->awaited;
	l->frame_length = 0;
}

static void hand_over(struct link *l, size_t size)
{
	size_t done = 0;
	for (size_t i = 0; i < size; i++)
		note(l, l->out[i]);
	while (l->open && done < size) {
		ssize_t n = write(l->fd, l->out + done, size - done);
		if (n <= 0)
			break;
		done += (size_t)n;
	}
	if (l->open)
		l->dropped += size - done;
	l->handed += done;
	memmove(l->out, l->out + size, l->out_end - size);
	l->out_end -= size;
	l->packet_due = l->latency ? *l->clock + l->latency : 0;
	plan(l);
}

static void hold(struct link *l, uint8_t byte)
{
	if (l->out_end == LINK_OUT) {
		l->lost++;
		return;
	}
	l->out[l->out_end++] = byte;
	if (l->from_held)
		return;
	if (l->latency == 0 && (byte == 0 || l->out_end == LINK_OUT))
		hand_over(l, l->out_end);
	else if (l->latency && l->out_end >= PACKET)
		hand_over(l, PACKET);
}

void link_sent(void *link, uint8_t byte)
{
	struct link *l = link;
	uint8_t bytes[2];
	l->frames += byte == 0;
	int n = damage_pass(&l->from, byte, bytes);
	for (int i = 0; i < n; i++)
		hold(l, bytes[i]);
}

void link_flush(struct link *l)
{
	if (l->latency == 0 && !l->from_held)
		hand_over(l, l->out_end);
}

// --- time
void link_set_latency(struct link *l, avr_cycle_count_t latency)
{
	l->latency = latency;
	l->packet_due = latency ? *l->clock + latency : 0;
	link_flush(l);
	plan(l);
}

void link_stall(struct link *l, bool to, avr_cycle_count_t cycles)
{
	*(to ? &l->to_held : &l->from_held) = *l->clock + cycles;
	plan(l);
}

void link_tick(struct link *l)
{
	avr_cycle_count_t now = *l->clock;
	if (passed(l->to_held, now))
		l->to_held = 0;
	if (passed(l->from_held, now))
		l->from_held = 0;
	if (l->from_held == 0 && (l->latency == 0 || passed(l->packet_due, now)))
		hand_over(l, l->out_end);
	else if (passed(l->packet_due, now))
		l->packet_due = now + l->latency;
	plan(l);
}
